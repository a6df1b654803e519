#include "tests/support/ccd_queries.hpp"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr std::int64_t kHeaderBytes = 16, kQueryBytes = 24 * 8 + 1, kTimeBytes = 16;

/// The whole file, of a size that was checked before.
class Bytes {
 public:
  explicit Bytes(const std::string& path) : path_(path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw InputError(text(path, ": no such file"));
    if (std::filesystem::is_directory(path, error))
      throw InputError(text(path, ": is a folder, not a file of queries"));
    if (!std::filesystem::is_regular_file(path, error)) throw InputError(text(path, ": is not a regular file"));
    file_.open(path, std::ios::binary | std::ios::ate);
    if (!file_) throw InputError(text(path, ": cannot be read"));
    size_ = static_cast<std::int64_t>(file_.tellg());
    file_.seekg(0);
  }
  std::int64_t size() const { return size_; }
  template <class T>
  void read(T* out, std::size_t n) {
    file_.read(reinterpret_cast<char*>(out), static_cast<std::streamsize>(n * sizeof(T)));
    if (!file_) throw InputError(text(path_, ": cannot be read to its end"));
  }

 private:
  std::string path_;
  std::ifstream file_;
  std::int64_t size_ = 0;
};

void check_size(const std::string& path, std::int64_t n, std::int64_t size) {
  const std::int64_t most = (size - kHeaderBytes) / kQueryBytes;
  if (n < 0 || n > most)
    throw InputError(text(path, ": announces ", n, " queries, but holds ", size, " bytes, enough for ", most));
  const std::int64_t expected = kHeaderBytes + n * kQueryBytes;
  if (size != expected) throw InputError(text(path, ": holds ", size, " bytes, but ", n, " queries take ", expected));
}

void read_times(const std::string& path, std::size_t n, std::vector<CcdQueries::ExactTime>& out) {
  Bytes bytes(path);
  const auto expected = static_cast<std::int64_t>(n) * kTimeBytes;
  if (bytes.size() != expected)
    throw InputError(text(path, ": holds ", bytes.size(), " bytes, but ", n, " queries take ", expected));
  struct Record {
    std::int32_t result, padding;
    double toi;
  };
  static_assert(sizeof(Record) == kTimeBytes);
  std::vector<Record> records(n);
  bytes.read(records.data(), n);
  out.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Record& r = records[i];
    if (r.result < 0 || r.result > 2)
      throw InputError(text(path, ": query ", i, " has result ", r.result, ", must be 0, 1 or 2"));
    if (r.result == 1 && !(r.toi >= 0 && r.toi <= 1))
      throw InputError(text(path, ": query ", i, " has time ", r.toi, ", must be 0 .. 1"));
    out[i] = {r.result == 1, r.toi};
  }
}

}  // namespace

CcdQueries load_ccd_queries(const std::string& path) {
  Bytes bytes(path);
  if (bytes.size() < kHeaderBytes)
    throw InputError(text(path, ": holds ", bytes.size(), " bytes, a file of queries begins with ", kHeaderBytes));
  std::int64_t header[2];
  bytes.read(header, 2);
  const auto [n, type] = header;
  if (type != 0 && type != 1)
    throw InputError(text(path, ": has type ", type, ", must be 0 (vertex and face) or 1 (two edges)"));
  check_size(path, n, bytes.size());
  const auto count = static_cast<std::size_t>(n);
  CcdQueries out;
  out.kind = type == 0 ? CcdQueries::Kind::vertex_face : CcdQueries::Kind::edge_edge;
  std::vector<double> x(24 * count);
  bytes.read(x.data(), x.size());
  out.points.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t p = 0; p < 8; ++p) out.points[i][p] = Eigen::Map<const Vec3>(&x[24 * i + 3 * p]);
  out.collides.resize(count);
  bytes.read(out.collides.data(), count);
  for (std::size_t i = 0; i < count; ++i)
    if (out.collides[i] != 0 && out.collides[i] != 1)
      throw InputError(text(path, ": query ", i, " has truth ", int{out.collides[i]}, ", must be 0 or 1"));
  const std::string times = path + ".oracle";
  std::error_code error;
  if (std::filesystem::exists(times, error)) read_times(times, count, out.times);
  return out;
}

}  // namespace kt
