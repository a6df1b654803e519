#pragma once
// Reports of ticks over a link that loses, repeats and disorders them. Each travels in several batches. A batch also
// tells the sum of all impulses up to its end: what was lost all the same is given to the body at the last place of
// contact that is known, so that no impulse is missing and none counts twice.
#include <deque>
#include <map>
#include <span>
#include <vector>

#include "haptics/remote/as_sent.hpp"

namespace kt {

/// A contact with the local model that its facet belongs to.
struct ContactPlace {
  TickContact contact{};
  int model_frame = -1;
  bool is_known() const noexcept { return contact.triangle >= 0; }
};

/// Reports of successive ticks.
struct ReportBatch {
  std::vector<LocalReport> reports;             ///< as_sent
  std::array<ImpulseCount, kMaxTools> sum{};    ///< of each tool, from the first tick on to the last of `reports`
  std::array<ContactPlace, kMaxTools> place{};  ///< of each tool, where it touched last up to there
  int adopted_frame = -1, adopted_tick = -1;    ///< of the local model in use: which, and since when
  int first() const { return reports.front().tick; }
  int last() const { return reports.back().tick; }
};

/// The side of the ticks. No limits are checked: what is added comes from one's own ticks.
class ReportOutbox {
 public:
  /// @param kept  reports that a batch can have at most    @param h  of a tick [s]
  ReportOutbox(std::size_t kept, double h) : kept_(kept), h_(h) {}
  void add(const LocalReport& report);
  /// The last `count` of them, or as many as there are. After the first add().
  ReportBatch batch(std::size_t count) const { return batch_to(last().tick, count); }
  /// The same up to a tick, which has() to be there.
  ReportBatch batch_to(int tick, std::size_t count) const;
  bool has(int tick) const { return !empty() && tick >= entries_.front().report.tick && tick <= last().tick; }
  bool empty() const { return entries_.empty(); }
  const std::array<ImpulseCount, kMaxTools>& sum() const { return sum_; }
  const LocalReport& last() const { return entries_.back().report; }

 private:
  struct Entry {
    LocalReport report;
    std::array<ImpulseCount, kMaxTools> sum{};  // with this one
    std::array<ContactPlace, kMaxTools> place{};
  };
  std::size_t kept_;
  double h_;
  std::deque<Entry> entries_;
  std::array<ImpulseCount, kMaxTools> sum_{};
  std::array<ContactPlace, kMaxTools> place_{};
};

/// The side of the body.
class ReportInbox {
 public:
  struct Counts {
    int received = 0;        ///< reports, each once
    int again = 0;           ///< that were there already, came after they had been given up, or are absurdly far ahead
    int lost = 0;            ///< that never came
    double booked_size = 0;  ///< impulse of these that was booked elsewhere [N s], sum of its sizes
  };

  explicit ReportInbox(double h) : h_(h) {}  ///< of a tick [s]
  /// Reports that are further ahead are left out: nobody is silent for so long without being given up.
  static constexpr int kMostAhead = 1 << 15;  ///< ticks
  void take(const ReportBatch& batch);

  /// What the body is to be given up to the end of this batch: the reports since the last close, and one more for the
  /// impulse of those that were lost. Later ones of those ticks count no more. They stay until the next call.
  std::span<const LocalReport> close(const ReportBatch& at);
  /// Ticks before the last close() whose reports were lost, of that interval.
  const std::vector<int>& lost() const { return lost_; }

  /// A report that is there says that a new local model is wanted at once.
  bool is_at_edge() const { return edge_ >= next_; }
  int next() const { return next_; }  ///< tick: all before it is given to the body
  /// Given to the body so far, and what is there of later ticks.
  std::array<ImpulseCount, kMaxTools> sum() const;
  const Counts& counts() const { return counts_; }

 private:
  void book(const ReportBatch& at);
  double h_;
  int next_ = 0, edge_ = -1;
  std::map<int, LocalReport> waiting_;  // of ticks from next_ on
  std::array<ImpulseCount, kMaxTools> given_{};
  std::array<ContactPlace, kMaxTools> place_{};  // of the last one that came and was given
  std::vector<LocalReport> out_;
  std::vector<int> lost_;
  Counts counts_;
};

}  // namespace kt
