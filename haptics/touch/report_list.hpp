#pragma once
// The reports that wait for a refresh, in order. Their memory is used again: a new LocalReport sets up room for forty
// contacts, which takes longer than all else that is done with it, and at 8 kHz more time than there is.
#include <algorithm>
#include <span>
#include <vector>

#include "haptics/tick/local_report.hpp"

namespace kt {

class ReportList {
 public:
  /// @param usual  reports for which there is room from the start
  explicit ReportList(std::size_t usual) { items_.reserve(usual); }

  /// A report to be written over; it counts from keep_next() on.
  LocalReport& next() {
    if (count_ == items_.size()) items_.emplace_back();
    return items_[count_];
  }
  void keep_next() noexcept { ++count_; }
  void add(const LocalReport& report) {
    next() = report;
    keep_next();
  }
  /// The oldest ones.
  void drop(std::size_t count) noexcept {
    std::copy(items_.begin() + static_cast<std::ptrdiff_t>(count), items_.begin() + static_cast<std::ptrdiff_t>(count_),
              items_.begin());
    count_ -= count;
  }
  void clear() noexcept { count_ = 0; }

  std::span<const LocalReport> all() const noexcept { return {items_.data(), count_}; }
  bool empty() const noexcept { return count_ == 0; }

 private:
  std::vector<LocalReport> items_;
  std::size_t count_ = 0;
};

}  // namespace kt
