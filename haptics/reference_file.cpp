// A reference as a file, for other methods to be compared against later.
#include <cinttypes>
#include <cstdio>
#include <fstream>

#include "haptics/reference.hpp"
#include "io/output_file.hpp"

namespace kt {
namespace {

std::string key_text(std::uint64_t key) {
  char out[17];
  std::snprintf(out, sizeof out, "%016" PRIx64, key);
  return out;
}

constexpr const char* kHeader = "# kilotouch reference ";
constexpr const char* kColumns = "t,force_x,force_y,force_z";

}  // namespace

void write_reference(const std::string& file, const Reference& reference) {
  std::string out = kHeader + key_text(reference.key) + ' ';
  for (const double value : {reference.rate_hz, reference.h, reference.seconds}) append_number(out += ' ', value);
  out += '\n';
  for (const std::string& warning : reference.warnings) out += "# warning " + warning + '\n';
  out += kColumns;
  out += '\n';
  for (std::size_t i = 0; i < reference.force.size(); ++i) {
    append_number(out, static_cast<double>(i + 1) * reference.h);
    for (int c = 0; c < 3; ++c) append_number(out += ',', reference.force[i][c]);
    out += '\n';
  }
  write_file_whole(file, out);
}

Reference read_reference(const std::string& file, std::uint64_t key) {
  std::ifstream in(file);
  if (!in) throw InputError(text(file, ": cannot read the reference (a run with --reference leaves reference.csv)"));
  std::string line;
  Reference out;
  const auto fail = [&](const std::string& what) { throw InputError(text(file, ": not a reference: ", what)); };
  const auto warning_mark = std::string("# warning ");
  if (!std::getline(in, line) || line.rfind(kHeader, 0) != 0 ||
      std::sscanf(line.c_str() + std::string(kHeader).size(), "%" SCNx64 " %lf %lf %lf", &out.key, &out.rate_hz, &out.h,
                  &out.seconds) != 4)
    fail("the first line must be \"" + std::string(kHeader) + "KEY RATE H SECONDS\"");
  while (std::getline(in, line) && line.rfind(warning_mark, 0) == 0)
    out.warnings.push_back(line.substr(warning_mark.size()));
  if (line != kColumns) fail("\"" + std::string(kColumns) + "\" expected");
  while (std::getline(in, line)) {
    double t = 0;
    Vec3 f;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &t, &f[0], &f[1], &f[2]) != 4)
      fail("four numbers a line expected");
    out.force.push_back(f);
  }
  if (out.key != key)
    throw InputError(text(file, ": is of another body, contact law or tool path (key ", key_text(out.key),
                          ", this run's is ", key_text(key), "); run with --reference to compute its own"));
  return out;
}

}  // namespace kt
