#include "apps/run/compared_runs.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "core/base/numbers.hpp"
#include "haptics/session/metrics.hpp"
#include "io/files/json_file.hpp"
#include "io/files/text_reader.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array kColumns{"t", "force_x", "force_y", "force_z", "tool_x", "tool_y", "tool_z"};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> out;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    out.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

void read_trace(const std::string& file, ComparedRun& out) {
  std::istringstream in(read_whole_file(file));
  std::string line;
  std::getline(in, line);
  const auto names = cells_of(line);
  std::array<std::size_t, kColumns.size()> column{};
  for (std::size_t c = 0; c < kColumns.size(); ++c) {
    column[c] = static_cast<std::size_t>(std::ranges::find(names, kColumns[c]) - names.begin());
    if (column[c] == names.size()) throw InputError(text(file, ": no trace of a run: no column ", kColumns[c]));
  }
  ComparedRun::Tool& tool = out.tools.emplace_back();
  for (int row = 1; std::getline(in, line); ++row) {
    const auto cells = cells_of(line);
    std::array<double, kColumns.size()> value{};
    for (std::size_t c = 0; c < kColumns.size(); ++c) {
      const std::string_view cell = column[c] < cells.size() ? cells[column[c]] : "";
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value[c]);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value[c]))
        throw InputError(text(file, ": row ", row, ": ", kColumns[c], " \"", cell, "\" is not a finite number"));
    }
    if (row == 1) out.h = value[0];
    constexpr double kRoundoff = 1e-6;  // of a tick
    if (!(out.h > 0) || std::abs(value[0] - row * out.h) > kRoundoff * out.h)
      throw InputError(text(file, ": row ", row, ": t is ", value[0], ", must be ", row * out.h, ", one row a tick"));
    tool.force.emplace_back(value[1], value[2], value[3]);
    tool.place.emplace_back(value[4], value[5], value[6]);
  }
  if (tool.force.empty()) throw InputError(text(file, ": no rows"));
}

/// Settings that a person changed while it ran: [tick, key, value] each.
void read_live_settings(const std::string& file, ComparedRun& out) {
  const Json session = read_json_file(file);
  if (!session.is_object() || !session.contains("setting_changes")) return;
  const Json& changes = session["setting_changes"];
  const auto is_change = [](const Json& c) {
    return c.is_array() && c.size() == 3 && c[0].is_number() && c[1].is_string();
  };
  if (!changes.is_array() || !std::ranges::all_of(changes, is_change))
    throw InputError(text(file, ": setting_changes must be a list of a tick, a key of the scene and its value"));
  for (const Json& change : changes) {
    const std::string key = change[1].get<std::string>();
    const std::string told = text(shown_json(change[2]), " at ", short_number(change[0].get<double>() * out.h), " s");
    const auto known = std::ranges::find(out.live, key, &std::pair<std::string, std::string>::first);
    if (known == out.live.end())
      out.live.emplace_back(key, told);
    else
      known->second += "; " + told;
  }
}

/// Every value that is no group, by its dotted key.
void collect(const Json& json, const std::string& prefix, std::vector<std::pair<std::string, Json>>& out) {
  for (const auto& [key, value] : json.items())
    if (value.is_object() && !value.empty())
      collect(value, prefix + key + '.', out);
    else
      out.emplace_back(prefix + key, value);
}

/// At time t, linear between ticks; before the first as there. A time that is a tick's, but for rounding, is that tick.
Vec3 at_time(const std::vector<Vec3>& values, double h, double t) {
  constexpr double kRoundoff = 1e-6;  // of a tick
  const double at = std::clamp(t / h - 1, 0.0, static_cast<double>(values.size() - 1));
  const double below = std::floor(at + kRoundoff), rest = at - below > kRoundoff ? at - below : 0;
  const auto i = static_cast<std::size_t>(below);
  return rest == 0 || i + 1 == values.size() ? values[i] : Vec3(values[i] + rest * (values[i + 1] - values[i]));
}

}  // namespace

ComparedRun read_run(const std::string& folder) {
  std::error_code none;
  if (!fs::exists(folder, none)) throw InputError(text(folder, ": no such folder"));
  if (!fs::is_directory(folder, none)) throw InputError(text(folder, ": is no folder; a run's results are wanted"));
  for (const char* name : {"/trace.csv", "/summary.json", "/scene.json"})
    if (!fs::exists(folder + name, none))
      throw InputError(text(folder, ": holds no run: ", name + 1, " is missing (kilotouch run ... --out leaves it)"));
  ComparedRun out{.folder = folder, .name = {}, .scene = {}, .summary = {}, .live = {}, .tools = {}};
  const fs::path path = fs::absolute(folder).lexically_normal();
  out.name = (path.has_filename() ? path : path.parent_path()).filename().string();
  out.scene = read_json_file(folder + "/scene.json");
  out.summary = read_json_file(folder + "/summary.json");
  if (!out.scene.is_object()) throw InputError(text(folder, "/scene.json: is no group { }"));
  if (!out.summary.is_object()) throw InputError(text(folder, "/summary.json: is no group { }"));
  read_trace(folder + "/trace.csv", out);
  if (fs::exists(folder + "/session.json", none)) read_live_settings(folder + "/session.json", out);
  if (fs::exists(folder + "/trace_2.csv", none)) read_trace(folder + "/trace_2.csv", out);
  return out;
}

std::vector<ChangedSetting> changed_settings(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> keys;  // in the order of the files
  std::vector<std::map<std::string, Json>> values(runs.size());
  for (std::size_t k = 0; k < runs.size(); ++k) {
    std::vector<std::pair<std::string, Json>> all;
    collect(runs[k].scene, "", all);
    for (const auto& [key, told] : runs[k].live) all.emplace_back(key + " while it ran", told);
    for (auto& [key, value] : all) {
      if (std::ranges::none_of(values, [&](const auto& known) { return known.contains(key); })) keys.push_back(key);
      values[k].emplace(key, std::move(value));
    }
  }
  std::vector<ChangedSetting> out;
  for (const std::string& key : keys) {
    ChangedSetting one{key, {}};
    for (const auto& of_run : values) one.values.push_back(of_run.contains(key) ? of_run.at(key) : Json(nullptr));
    if (std::ranges::any_of(one.values, [&](const Json& v) { return v != one.values[0]; })) out.push_back(one);
  }
  return out;
}

ForceDifference compare_runs(const ComparedRun& first, const ComparedRun& other, std::size_t tool) {
  ForceDifference out;
  const ComparedRun::Tool &own = first.tools.at(tool), &its = other.tools.at(tool);
  const double end =
      std::min(first.h * static_cast<double>(own.force.size()), other.h * static_cast<double>(its.force.size()));
  const auto count = std::max<std::size_t>(1, static_cast<std::size_t>(std::floor(end / first.h + 1e-6)));
  out.seconds = static_cast<double>(count) * first.h;
  double sum_sq = 0, own_sq = 0, largest_force = 0;
  out.same_bits = own.force.size() == its.force.size() && first.h == other.h;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i + 1) * first.h;
    const Vec3 f = at_time(its.force, other.h, t);
    const double apart = (f - own.force[i]).norm();
    out.same_bits = out.same_bits && f == own.force[i];
    sum_sq += apart * apart;
    own_sq += own.force[i].squaredNorm();
    largest_force = std::max(largest_force, own.force[i].norm());
    out.apart = std::max(out.apart, (at_time(its.place, other.h, t) - own.place[i]).norm());
    if (apart > out.largest_n) {
      out.largest_n = apart;
      out.at = t;
    }
  }
  const auto n = static_cast<double>(count);
  out.rms_n = std::sqrt(sum_sq / n);
  out.rms_share = own_sq > 0 ? std::sqrt(sum_sq / own_sq) : out.rms_n > 0 ? 1 : 0;
  out.largest_share = largest_force > 0 ? out.largest_n / largest_force : out.largest_n > 0 ? 1 : 0;
  const double floor = kForceFloor * std::sqrt(own_sq / n);
  int judged = 0, perhaps = 0, surely = 0, common = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 f = at_time(its.force, other.h, static_cast<double>(i + 1) * first.h);
    const double size = std::max(own.force[i].norm(), f.norm()), apart = (f - own.force[i]).norm();
    if (size <= floor) continue;
    ++judged;
    common += std::min(own.force[i].norm(), f.norm()) > floor;
    perhaps += apart > ForceDifference::kPerhaps * size;
    surely += apart > ForceDifference::kSurely * size;
  }
  if (judged > 0) {
    out.perhaps_share = static_cast<double>(perhaps) / judged;
    out.surely_share = static_cast<double>(surely) / judged;
  }
  out.common_contact = common * first.h;
  out.noticed = common == 0                                      ? Noticed::not_judged
                : out.surely_share > ForceDifference::kShortest  ? Noticed::yes
                : out.perhaps_share > ForceDifference::kShortest ? Noticed::perhaps
                                                                 : Noticed::no;
  return out;
}

}  // namespace kt
