#include "haptics/device/recording.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/base/percentile.hpp"
#include "io/files/text_reader.hpp"

namespace kt {
namespace {

using Cells = std::vector<std::string>;

constexpr double kFarthest = 1e6;  // [m], as the waypoints of a scene
constexpr double kLongest = 1e9;   // [s], from the first row on: a clock that was set in between

std::string trimmed(std::string_view cell) {
  const auto is_mark = [](char c) { return is_space(c) || c == '"'; };
  while (!cell.empty() && is_mark(cell.front())) cell.remove_prefix(1);
  while (!cell.empty() && is_mark(cell.back())) cell.remove_suffix(1);
  return std::string(cell);
}

Cells split_row(std::string_view row) {
  Cells out;
  const char mark = row.find(';') != row.npos ? ';' : row.find(',') != row.npos ? ',' : '\t';
  if (mark != '\t' || row.find('\t') != row.npos) {
    for (std::size_t at = 0; at <= row.size();) {
      const std::size_t end = std::min(row.find(mark, at), row.size());
      out.push_back(trimmed(row.substr(at, end - at)));
      at = end + 1;
    }
  } else {
    for (std::size_t at = 0; (at = row.find_first_not_of(' ', at)) != row.npos;) {
      const std::size_t end = std::min(row.find(' ', at), row.size());
      out.push_back(trimmed(row.substr(at, end - at)));
      at = end;
    }
  }
  while (!out.empty() && out.back().empty()) out.pop_back();  // a separator at the end of the row
  return out;
}

bool is_number(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return !cell.empty() && end == cell.data() + cell.size() && error != std::errc::invalid_argument;
}

bool is_header(const Cells& cells) { return std::ranges::none_of(cells, is_number); }

/// "Time [s]" -> "time": lower case, without the unit that is meant anyway.
std::string plain_name(std::string name, const std::string& unit) {
  for (char& c : name) c = lower(c);
  for (const std::string& suffix :
       {" [" + unit + "]", "[" + unit + "]", " (" + unit + ")", "(" + unit + ")", "_" + unit})
    if (name.ends_with(suffix)) return name.substr(0, name.size() - suffix.size());
  return name;
}

/// Where a row has its time and place, and what else it has.
struct Columns {
  std::array<std::size_t, 8> at{0, 1, 2, 3, 4, 5, 6, 7};
  bool has_turn = false;  ///< the last four are there
  std::string unread;     ///< of the others, for a person; empty: none
};

std::string shown(const Cells& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + in_quotes(name);
  return out;
}

Columns named_columns(const TextReader& in, const Cells& names) {
  constexpr const char* kNames[8][3] = {{"t", "time", "timestamp"}, {"x", "tool_x", "x"},     {"y", "tool_y", "y"},
                                        {"z", "tool_z", "z"},       {"qw", "tool_qw", "q_w"}, {"qx", "tool_qx", "q_x"},
                                        {"qy", "tool_qy", "q_y"},   {"qz", "tool_qz", "q_z"}};
  constexpr const char* kUnits[8] = {"s", "m", "m", "m", "", "", "", ""};
  Columns out;
  Cells others = names;
  std::size_t turns = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    const auto is_it = [&](const std::string& name) {
      return std::ranges::find(kNames[c], plain_name(name, kUnits[c])) != std::end(kNames[c]);
    };
    const auto found = std::ranges::find_if(names, is_it);
    if (found == names.end() && c >= 4) continue;
    turns += c >= 4;
    if (found == names.end())
      in.fail("no column is named ", kNames[c][0], " among ", shown(names),
              "; must be t, x, y, z, in s and m (or no names at all)");
    out.at[c] = static_cast<std::size_t>(found - names.begin());
    std::erase(others, *found);
  }
  if (turns != 0 && turns != 4)
    in.fail("of qw, qx, qy, qz only ", turns, turns == 1 ? " is" : " are", " among ", shown(names),
            "; an orientation needs all four");
  out.has_turn = turns == 4;
  std::erase(others, "");
  if (!others.empty()) out.unread = shown(others);
  return out;
}

/// In more digits than a double has: of a clock's 1.7e9 s that would keep 0.2 us.
long double to_time(const TextReader& in, std::string_view cell) {
  in.to_number(cell, "t");
  if (cell.starts_with('+')) cell.remove_prefix(1);
  long double out = 0;
  std::from_chars(cell.data(), cell.data() + cell.size(), out);
  return out;
}

double to_place(const TextReader& in, const std::string& cell, const char* name) {
  const double value = in.to_number(cell, name);
  if (std::abs(value) > kFarthest) in.fail(name, " is ", in_quotes(cell), " m; must be within ", kFarthest, " m");
  return value;
}

std::string_view cell_at(const TextReader& in, const Cells& cells, std::size_t column) {
  if (column >= cells.size())
    in.fail("the row has ", cells.size(), cells.size() == 1 ? " value" : " values", ", \"t,x,y,z\" needs at least ",
            column + 1, ": ", shown(cells));
  if (cells[column].find(',') != std::string::npos)
    in.fail(in_quotes(cells[column]), " is not a number; write a decimal point");
  return cells[column];
}

/// Of unit length to what a text keeps of it; one that is none is an error, as an Euler angle would be.
Quaternion to_turn(const TextReader& in, const std::array<std::string, 4>& cells) {
  constexpr double kUnit = 1e-2, kExact = 1e-12;
  constexpr const char* kNames[] = {"qw", "qx", "qy", "qz"};
  std::array<double, 4> q{};
  for (std::size_t c = 0; c < 4; ++c) q[c] = in.to_number(cells[c], kNames[c]);
  const Quaternion out(q[0], q[1], q[2], q[3]);
  const double square = out.squaredNorm();
  if (!(std::abs(square - 1) < kUnit))
    in.fail("(qw, qx, qy, qz) is (", cells[0], ", ", cells[1], ", ", cells[2], ", ", cells[3], "), of length ",
            std::sqrt(square), "; must be a unit quaternion");
  return std::abs(square - 1) < kExact ? out : out.normalized();
}

/// Rows that are farther apart than a tick, in one line.
void note_gaps(const std::vector<TimedPoint>& path, const std::vector<int>& lines, double h,
               std::vector<std::string>& notes) {
  constexpr double kMuch = 1.1;  // of a tick: a clock's own jitter is less
  std::vector<double> apart;
  for (std::size_t i = 1; i < path.size(); ++i) apart.push_back(path[i].t - path[i - 1].t);
  const auto gaps = std::ranges::count_if(apart, [&](double dt) { return dt > kMuch * h; });
  if (gaps == 0) return;
  const auto longest = std::ranges::max_element(apart);
  const int line = lines[static_cast<std::size_t>(longest - apart.begin()) + 1];
  const double most = *longest;
  std::ranges::nth_element(apart, apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2));
  notes.push_back(text("rows are farther apart than a tick of ", 1e3 * h, " ms ", gaps, " times, usually ",
                       1e3 * apart[apart.size() / 2], " ms, at most ", 1e3 * most, " ms before line ", line,
                       ": the tool moves evenly in between (times are in s)"));
}

/// Rows that lie far apart, of a tool that hardly moves between them, are those of a faster recording whose times are
/// in other units. Places of a robot's way, some seconds apart, are taken.
void check_unit(const std::string& file, const std::vector<TimedPoint>& path) {
  constexpr std::size_t kMany = 20;
  constexpr double kUsual = 0.4, kSlow = 1e-3;  // [s], [m/s]
  std::vector<double> apart, speed;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double way = (path[i].x - path[i - 1].x).norm(), dt = path[i].t - path[i - 1].t;
    apart.push_back(dt);
    if (way > 0) speed.push_back(way / dt);
  }
  if (path.size() < kMany || speed.empty()) return;
  const double usual = percentile(apart, 0.5), usual_speed = percentile(speed, 0.5);
  if (usual >= kUsual && usual_speed < kSlow)
    throw InputError(text(file, ": the ", path.size(), " rows are usually ", usual, " s apart, and the tool moves at ",
                          usual_speed, " m/s between them; must be below ", kUsual, " s or above ", kSlow,
                          " m/s: times are in seconds (milliseconds?), places in metres"));
}

/// Line ends as everywhere: a carriage return alone is one, too.
std::string with_plain_line_ends(std::string data) {
  for (std::size_t i = 0; i < data.size(); ++i)
    if (data[i] == '\r' && (i + 1 == data.size() || data[i + 1] != '\n')) data[i] = '\n';
  return data;
}

}  // namespace

Recording read_recording(const std::string& file, double h) {
  TextReader in(file, with_plain_line_ends(read_whole_file(file)));
  in.drop_last_nuls();
  Recording out;
  std::vector<int> lines;
  Columns columns;
  long double first = 0;
  std::string before;  // time of the row before, as the file has it
  bool is_first = true;
  while (const auto line = in.line()) {
    const Cells cells = split_row(line->substr(0, line->find('#')));  // behind it is a comment
    if (cells.empty()) continue;
    if (std::exchange(is_first, false)) {
      if (is_header(cells)) {
        columns = named_columns(in, cells);
        continue;
      }
      if (cells.size() > 4) columns.unread = cells.size() == 5 ? "column 5" : text("columns 5 to ", cells.size());
    }
    const auto cell = [&](std::size_t c) { return std::string(cell_at(in, cells, columns.at[c])); };
    const long double t = to_time(in, cell(0));
    if (out.path.empty()) first = t;
    const auto since = static_cast<double>(t - first);
    if (!out.path.empty() && !(since > out.path.back().t))
      in.fail("time ", in_quotes(cell(0)), " s does not follow that of the row before, ", in_quotes(before), " s");
    if (since > kLongest)
      in.fail("time ", in_quotes(cell(0)), " s is ", since, " s behind that of the first row; must be within ",
              kLongest, " s (are times in seconds?)");
    before = cell(0);
    out.path.push_back({since, {to_place(in, cell(1), "x"), to_place(in, cell(2), "y"), to_place(in, cell(3), "z")}});
    if (columns.has_turn)
      out.poses.push_back({since, {out.path.back().x, to_turn(in, {cell(4), cell(5), cell(6), cell(7)})}});
    lines.push_back(in.line_number());
  }
  if (out.path.empty()) throw InputError(text(file, ": the recording is empty"));
  if (!columns.unread.empty())
    out.notes.push_back(text("not read: ", columns.unread,
                             columns.has_turn ? " (only t, x, y, z and qw, qx, qy, qz are)"
                                              : " (only t, x, y, z are; the tool's orientation is that of tool.turn "
                                                "and tool.spin, or of columns named qw, qx, qy, qz)"));
  check_unit(file, out.path);
  note_gaps(out.path, lines, h, out.notes);
  return out;
}

}  // namespace kt
