// A reference as a file, for other methods to be compared against later.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <sstream>

#include "core/base/numbers.hpp"
#include "io/files/output_file.hpp"
#include "io/files/text_reader.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

constexpr const char* kHeader = "# kilotouch reference ";
constexpr const char* kColumns = "t,force_x,force_y,force_z";
constexpr const char* kSecondColumns = ",force_2_x,force_2_y,force_2_z";

std::vector<std::string> split_line(std::string_view line, char at = ',') {
  std::vector<std::string> out(1);
  for (const char c : line)
    if (c == at)
      out.emplace_back();
    else if (c != '\r')
      out.back() += c;
  return out;
}

/// "KEY  RATE H SECONDS"; of an older file some are missing. False: it is none.
bool read_header(std::string_view line, std::size_t least, Reference& out) {
  if (!line.starts_with(kHeader)) return false;
  line.remove_prefix(std::string_view(kHeader).size());
  std::vector<std::string> words = split_line(line.substr(0, line.find('\n')), ' ');
  std::erase(words, "");
  if (words.size() < least || words.empty()) return false;
  const char* const end = words[0].data() + words[0].size();
  if (std::from_chars(words[0].data(), end, out.key, 16).ptr != end) return false;
  double* const values[] = {&out.rate_hz, &out.h, &out.seconds};
  for (std::size_t i = 0; i < 3 && i + 1 < words.size(); ++i) {
    const std::optional<double> value = to_double(words[i + 1]);
    if (!value && i + 1 < least) return false;
    if (value) *values[i] = *value;
  }
  return true;
}

/// Finite, as many as there is room for, and no more.
bool read_row(const std::string& line, std::span<double> out) {
  const std::vector<std::string> cells = split_line(line);
  if (cells.size() != out.size()) return false;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::optional<double> value = to_double(cells[i]);
    if (!value || !std::isfinite(*value)) return false;
    out[i] = *value;
  }
  return true;
}

}  // namespace

void write_reference(const std::string& file, const Reference& reference) {
  std::string out = kHeader + sixteen_digits(reference.key) + ' ';
  for (const double value : {reference.rate_hz, reference.h, reference.seconds}) append_number(out += ' ', value);
  out += '\n';
  for (const std::string& warning : reference.warnings) out += "# warning " + warning + '\n';
  const bool has_second = !reference.second_force.empty();
  out += kColumns;
  if (has_second) out += kSecondColumns;
  out += '\n';
  for (std::size_t i = 0; i < reference.force.size(); ++i) {
    append_number(out, static_cast<double>(i + 1) * reference.h);
    for (int c = 0; c < 3; ++c) append_number(out += ',', reference.force[i][c]);
    for (int c = 0; has_second && c < 3; ++c) append_number(out += ',', reference.second_force[i][c]);
    out += '\n';
  }
  write_file_whole(file, out);
}

std::uint64_t key_in_reference(const std::string& file) {
  const std::string content = read_whole_file(file);
  Reference header;
  if (!read_header(content, 1, header))
    throw InputError(text(file, ": not a reference: the first line must be \"", kHeader, "KEY RATE H SECONDS\""));
  return header.key;
}

Reference read_reference(const std::string& file, std::uint64_t key) {
  if (!std::filesystem::exists(file))
    throw InputError(text(file, ": cannot read the reference (a run with --reference leaves reference.csv)"));
  std::istringstream in(read_whole_file(file));
  std::string line;
  Reference out;
  const auto fail = [&](const std::string& what) { throw InputError(text(file, ": not a reference: ", what)); };
  const auto warning_mark = std::string("# warning ");
  if (!std::getline(in, line) || !read_header(line, 4, out))
    fail("the first line must be \"" + std::string(kHeader) + "KEY RATE H SECONDS\"");
  while (std::getline(in, line) && line.rfind(warning_mark, 0) == 0)
    out.warnings.push_back(line.substr(warning_mark.size()));
  const bool has_second = line == std::string(kColumns) + kSecondColumns;
  if (line != kColumns && !has_second) fail("\"" + std::string(kColumns) + "\" expected");
  while (std::getline(in, line)) {
    std::array<double, 7> row{};  // t, and a force a tool
    if (!read_row(line, std::span(row).first(has_second ? 7 : 4)))
      fail(text(has_second ? "seven" : "four", " finite numbers a line expected, found \"", line, "\""));
    out.force.emplace_back(row[1], row[2], row[3]);
    if (has_second) out.second_force.emplace_back(row[4], row[5], row[6]);
  }
  if (!(out.rate_hz > 0 && out.h > 0 && std::isfinite(out.rate_hz) && std::isfinite(out.h)))
    fail("RATE and H of the first line must be above 0");
  if (out.key != key)
    throw InputError(text(file, ": is of another body, contact law or tool path (key ", sixteen_digits(out.key),
                          ", this run's is ", sixteen_digits(key), "); run with --reference to compute its own"));
  return out;
}

Reference read_forces(const std::string& file) {
  std::istringstream in(read_whole_file(file));
  const auto fail = [&](const std::string& what) {
    throw InputError(text(file, ": no forces to compare with: ", what));
  };
  std::string line;
  Reference out;
  while (std::getline(in, line) && line.starts_with('#')) read_header(line, 2, out);
  const std::vector<std::string> names = split_line(line);
  std::array<std::size_t, 4> column;
  for (std::size_t c = 0; c < column.size(); ++c) {
    constexpr const char* kWanted[] = {"t", "force_x", "force_y", "force_z"};
    column[c] = static_cast<std::size_t>(std::ranges::find(names, kWanted[c]) - names.begin());
    if (column[c] == names.size()) fail(text("no column ", kWanted[c]));
  }
  for (int row = 1; std::getline(in, line); ++row) {
    const std::vector<std::string> cells = split_line(line);
    std::array<double, 4> value{};
    for (std::size_t c = 0; c < column.size(); ++c) {
      const std::string cell = column[c] < cells.size() ? cells[column[c]] : "";
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value[c]);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value[c]))
        fail(text("row ", row, ": \"", cell, "\" is not a finite number"));
    }
    if (row == 1) out.h = value[0];
    constexpr double kRoundoff = 1e-6;  // of a tick
    if (std::abs(value[0] - row * out.h) > kRoundoff * out.h) fail(text("row ", row, ": not one row a tick"));
    out.force.emplace_back(value[1], value[2], value[3]);
  }
  if (out.force.empty()) fail("no rows");
  return out;
}

}  // namespace kt
