#pragma once
// What ReducerChoice::set_up found out about a body, seconds of CPU time, kept for whoever begins with the same body,
// bit for bit, at the same place again: another run, a reset, a recording.
#include <cstdint>
#include <memory>
#include <mutex>

#include "core/local/graded_body.hpp"
#include "haptics/cost/expected_touch.hpp"
#include "haptics/refresh/reducer_candidates.hpp"

namespace kt {

struct TangentModel;

/// What set_up() leaves, from which the run goes on to the same bits.
struct ReducerSetUp {
  std::vector<ReducerCandidate> candidates;  ///< by predicted cost
  std::size_t chosen = 0;
  std::optional<Excitation> excitation;
  GradedBody graded;
};

/// Everything that set_up() depends on: numbers as they are, of the tangent a hash of its bits.
struct SetUpKey {
  std::string reducer;
  std::vector<double> numbers;
  std::vector<int> nodes;  ///< of the patch
  std::uint64_t tangent = 0;
  bool operator==(const SetUpKey&) const = default;
};

/// @param excitation  that is known before
SetUpKey set_up_key(const std::string& reducer, int rings, const ReducerNeeds& needs, const ExpectedTouch& touch,
                    const std::optional<Excitation>& excitation, const TangentModel& tangent, const SurfacePatch& patch,
                    const ContactSite& site);

/// The last one of a body. From any thread.
class KeptSetUp {
 public:
  /// Null: it is another one.
  std::shared_ptr<const ReducerSetUp> find(const SetUpKey& key) const;
  void keep(SetUpKey key, std::shared_ptr<const ReducerSetUp> found);

 private:
  mutable std::mutex guard_;
  SetUpKey key_;
  std::shared_ptr<const ReducerSetUp> found_;
};

}  // namespace kt
