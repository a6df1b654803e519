// Rows of a run: what was pushed is read, in memory and on the disk; a full disk is told and loses nothing.
#include "core/base/record.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>

#include "core/base/error.hpp"

namespace kt {
namespace {

struct Row {
  std::uint64_t number = 0;
  double values[31] = {};
};

Row row(std::size_t i) {
  Row out;
  out.number = i * 0x9e3779b97f4a7c15ull;
  out.values[30] = static_cast<double>(i);
  return out;
}

constexpr std::size_t kManyMegabytes = 300;  // [MB]
constexpr std::size_t kRows = kManyMegabytes * 1000 * 1000 / sizeof(Row);

void expect_rows(const Record<Row>& rows, std::size_t count) {
  ASSERT_EQ(rows.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    ASSERT_EQ(rows[i].number, row(i).number) << i;
    ASSERT_EQ(rows[i].values[30], static_cast<double>(i));
  }
}

/// [bytes], private or of files
double resident() {
  std::ifstream in("/proc/self/statm");
  double all = 0, here = 0;
  in >> all >> here;
  return 4096 * here;
}

TEST(Record, HasWhatWasPushedInMemoryAndOnTheDisk) {
  Record<Row> rows;
  const std::size_t few = RecordBytes::kInMemory / sizeof(Row);
  for (std::size_t i = 0; i < few; ++i) rows.push_back(row(i));
  EXPECT_FALSE(rows.is_on_disk());
  rows.push_back(row(few));
  EXPECT_TRUE(rows.is_on_disk());
  for (std::size_t i = few + 1; i < 5 * few; ++i) rows.push_back(row(i));
  expect_rows(rows, 5 * few);
  const Record<Row> copy = rows;
  const Record<Row> moved = std::move(rows);
  expect_rows(copy, 5 * few);
  expect_rows(moved, 5 * few);
}

TEST(Record, OfALongRunTakesNoMemory) {
  Record<Row> rows;
  const double before = resident();
  for (std::size_t i = 0; i < kRows; ++i) rows.push_back(row(i));
  // Two steps of the file, and what a sanitizer takes for its own.
  EXPECT_LT(resident() - before, 130e6);
  EXPECT_EQ(rows[kRows / 2].number, row(kRows / 2).number);
  EXPECT_EQ(rows.back().number, row(kRows - 1).number);
}

TEST(Record, ResizesAndIsASpan) {
  Record<double> numbers;
  numbers.resize(3, 7.0);
  numbers.push_back(1);
  EXPECT_EQ(std::span<const double>(numbers).size(), 4u);
  EXPECT_EQ(numbers[2], 7);
  numbers.truncate(1);
  EXPECT_EQ(numbers.size(), 1u);
  EXPECT_EQ(numbers.back(), 7);
}

TEST(Record, OnAFullDiskIsToldAndKept) {
  // A limit of the size of files stands for a full disk.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit less = before;
  less.rlim_cur = std::size_t{40} << 20;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &less), 0);
  Record<Row> rows;
  std::string told;
  try {
    for (std::size_t i = 0; i < kRows; ++i) rows.push_back(row(i));
  } catch (const RunError& e) {
    told = e.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(told.find("File too large"), std::string::npos) << told;
  EXPECT_GT(rows.size(), RecordBytes::kInMemory / sizeof(Row));
  expect_rows(rows, rows.size());
}

}  // namespace
}  // namespace kt
