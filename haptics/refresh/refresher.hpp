#pragma once
// The slow side of a session: catch up, linearize, reduce around the contact, prepare.          Paper section II.
#include <array>
#include <cmath>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/stages.hpp"
#include "haptics/refresh/contact_nodes.hpp"
#include "haptics/refresh/excitation.hpp"
#include "haptics/refresh/fine_refresh.hpp"
#include "haptics/refresh/look_ahead.hpp"
#include "haptics/refresh/patch_site.hpp"
#include "haptics/refresh/reducer_choice.hpp"
#include "haptics/refresh/refresh_pace.hpp"
#include "haptics/refresh/refresh_record.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/tick/local_report.hpp"
#include "haptics/tick/local_simulation.hpp"
#include "haptics/tick/way_out.hpp"
#include "self_contact/touching_euler.hpp"

namespace kt {

struct RefreshMemory {
  ReducerState choice;
  RefreshPace pace;                   ///< its time 0 is now
  std::vector<SpectrumMeter> forces;  ///< of each tool; empty: none was measured
};

class Refresher {
 public:
  /// @param self_contact  none: the body passes through itself
  /// @param kept          set-ups of this body's reducers; null: none are kept. Borrowed
  Refresher(const DeformableModel& model, const Surface& surface, const TouchOptions& options, const State& start,
            SelfContact* self_contact = nullptr, KeptSetUp* kept = nullptr);

  /// The local model for the tick that starts at time t, after the reports of all ticks before it. It goes on from
  /// `motion`, that of the local model in use at that tick or some ticks earlier; without one, from the body's own.
  /// @param at       where the tools are at t
  /// @param reports  since the last refresh; with `motion`, also that of the tick before it
  /// @param when_reduced  not empty: called when all but a few ticks' work is done. The model then does not go on from
  ///                      `motion`: the caller gives it a later one by carry_over()
  std::unique_ptr<PreparedLocalModel> refresh(double t, std::span<const Pose> at, std::span<const LocalReport> reports,
                                              const LocalMotion* motion = nullptr,
                                              const std::function<void()>& when_reduced = {});

  /// The new model goes on moving as the one in use did, with its contacts. Until the next refresh.
  /// @param reports  that of the tick before the motion, if it was not lost
  void carry_over(const LocalMotion& motion, std::span<const LocalReport> reports, PreparedLocalModel& out) const;

  /// How long the next local model will be on its way [s], as far as can be told.
  void expect_delay(double seconds) { known_.delay = seconds; }

  /// Ticks until the next refresh, of `usual` ones: fewer while the body bends more within them than the local model
  /// tells.
  int next_interval(int usual) const;

  /// What is known for the next refreshes, apart from the body and the tools.
  RefreshMemory memory() const;
  /// Before the first refresh: with what another run of this body knew, and the refined cells of its last local model
  /// (ContactNodes::keep_fine). That refresh is given the motion of this model and its last reports.
  void go_on_from(const RefreshMemory& memory, int frame, std::shared_ptr<const FinePatch> fine,
                  std::vector<Vec3> offset);
  /// The same body goes on from another refresher, with other settings: what was measured stays known.
  void go_on_from(Refresher& before);

  /// What the last refresh took [ms of CPU time]; reducer auto keeps within its budget.
  void charge(double cpu_ms);
  /// A replay: changes of reducer as they were.
  void follow(std::vector<ReducerChange> changes) { choice_.follow(std::move(changes)); }

  const ReducerChoice& choice() const { return choice_; }
  const State& state() const { return global_.state(); }
  /// After the global step in which a node was furthest from the start: for looks that are taken later.
  const State& most_deformed() const { return known_.most_deformed; }
  /// Changes of reducer since they were taken.
  std::vector<ReducerChange> take_changes() { return choice_.take_changes(); }
  StepStatistics statistics() const { return global_.statistics(); }
  const RefreshRecord& record() const { return record_; }  ///< of the last refresh
  bool look_for_crossings = false;  ///< of the surface with itself after each global step, with self-contact

 private:
  std::optional<State> catch_up(double t, std::span<const LocalReport> reports, bool looks_ahead);
  std::vector<ToolPlace> place_tools(double t, std::span<const Pose> at, std::span<const LocalReport> reports,
                                     std::array<int, kMaxTools>& way_out) const;
  std::unique_ptr<PreparedLocalModel> prepare_for_ticks(LocalModel local, std::span<const Pose> at,
                                                        const ContactSite& site,
                                                        const std::array<int, kMaxTools>& way_out,
                                                        const LocalReport* last);
  VectorX unloaded(const PreparedLocalModel& model, const LocalReport* last) const;
  LocalModel reduce(const SurfacePatch& patch, const ContactSite& site, const State* ahead);
  LocalModel reduce_at(const State& state, TangentKind kind, const SurfacePatch& patch, const ContactSite& site);
  void linearize_at(const State& state, TangentKind kind);
  struct Refined {
    std::shared_ptr<const FinePatch> patch;  // null: the cells stay as they are
    double ms = 0, cpu_ms = 0;
    StageTimes stages;  // if they are asked for
  };
  std::future<Refined> start_refining(TangentKind kind, std::span<const SeenTool> tools);
  void take_refined_before();
  void refine_for_next(TangentKind kind);
  void see_tools(double t, std::span<const Pose> at, std::span<const LocalReport> reports);
  LocalScheme choose_scheme(LocalModel& local);
  void measure_forces(std::span<const LocalReport> reports);
  int tick() const {
    return static_cast<int>(std::lround(known_.last * options_.local.rate_hz));
  }  // of the last refresh
  int count_inverted() const;
  void note_deformation();
  void report_self_contact();
  void judge_linearization(std::span<const ContactHold> holds);
  std::optional<State> foresee(double t, std::span<const LocalReport> reports);
  Vec3 way_until_used(const Vec3& velocity, int tool) const;
  std::optional<WayOut> find_way_out(int tool, const Pose& pose) const;
  double interval(double t) const;
  const Surface& surface_;
  TouchOptions options_;
  std::vector<TouchTool> tools_;
  Smoothing smoothing_;
  ContactNodes nodes_;  // of the contacts that ticks report
  WayOutSearch way_out_;
  std::unique_ptr<HapticMethod> method_;  // for its part on the slow side
  SelfContact* self_contact_;             // none: the body passes through itself
  GlobalSimulation global_;
  ReducerChoice choice_;
  RefreshRecord record_;
  TangentModel tangent_;               // of the last refresh, of the body's own nodes: its storage
  VectorX linearized_x_;               // all positions there
  std::optional<LocalScheme> scheme_;  // none: whichever fits
  Metric metric_;
  bool refreshes_early_, has_apron_;         // the baselines do not
  bool is_new_ = true;                       // no model was made yet
  std::optional<FineRefresh> fine_;          // of a scene that is refined around the contact
  std::vector<SeenTool> seen_, seen_later_;  // of this refresh, and as the next one may see them
  std::vector<int> fine_patch_;              // of this refresh: triangles
  FineRefresh::Due fine_due_ = FineRefresh::Due::now;
  /// What is known of the body whatever the settings.
  struct Known {
    State before;                       // where the last global step began
    VectorX start;                      // positions before the first step [m], (3n)
    State most_deformed;                // after the step that moved a node furthest from there
    double furthest_sq = 0;             // [m^2]
    double delay = 0;                   // of the next local model on its way [s]
    double last = 0;                    // time of the last refresh [s]
    double late = 1;                    // see SeenTool
    PastPlaces past;                    // of the tools
    int frame = 0;                      // of the next local model
    RefreshPace pace;                   // when the next is due
    std::vector<SpectrumMeter> forces;  // of each tool, from its first contact on
  } known_;
  std::future<Refined> refining_;  // for the next refresh; it reads the tangent of this one. The last: it ends first
};

}  // namespace kt
