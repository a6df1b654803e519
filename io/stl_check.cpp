#include "io/stl_check.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "io/text_reader.hpp"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t kHeader = 84, kTriangle = 50;  // bytes

template <class T>
void append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string with_header(long long faces, const std::string& body) {
  std::string out(80, '\0');
  append(out, static_cast<std::uint32_t>(faces));
  return out + body;
}

/// Text STL: every facet needs three vertices of three finite numbers.
CheckedStl check_text(const std::string& path, const std::string& data) {
  TextReader in(path, data);
  long long facets = 0, corners = 0;
  bool ended = false;
  std::string body;
  in.skip_line();  // "solid" and a name of any words
  while (const auto word = in.word()) {
    ended = *word == "endsolid";
    if (*word == "vertex") {
      if (corners++ == 3 * facets) body.append(12, '\0');  // the normal
      for (int k = 0; k < 3; ++k) {
        const double value = in.number("a vertex coordinate", false);
        if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
          in.fail("a vertex coordinate is ", value, "; must be in the range of a 32-bit float (3.4e38)");
        append(body, static_cast<float>(value));
      }
    } else if (*word == "endfacet") {
      if (corners != 3 * ++facets) in.fail("facet ", facets - 1, " has not 3 vertices");
      body.append(2, '\0');
    }
    if (ended) in.skip_line();
  }
  if (!ended) in.fail("file ends without endsolid: it is truncated");
  if (corners != 3 * facets) in.fail("vertices follow the last facet");
  return {facets, with_header(facets, body)};
}

void check_binary(const std::string& path, const std::string& data, std::uint32_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    float corner[9];
    std::memcpy(corner, data.data() + kHeader + kTriangle * i + 12, sizeof corner);
    for (int k = 0; k < 9; ++k)
      if (!std::isfinite(corner[k]))
        throw InputError(text(path, ": coordinate ", "xyz"[k % 3], " of corner ", k / 3, " of triangle ", i, " is ",
                              corner[k], "; must be finite"));
  }
}

}  // namespace

/// Binary STL: 80 bytes, a count, 50 bytes a triangle. A text STL starts with "solid", but so do some binary ones: the
/// size decides.
CheckedStl check_stl(const std::string& path, const std::string& data) {
  std::uint32_t n = 0;
  if (data.size() >= kHeader) std::memcpy(&n, data.data() + 80, sizeof n);
  const std::size_t expected = kHeader + kTriangle * n;
  if (data.size() >= kHeader && data.size() == expected) {
    check_binary(path, data, n);
    return {n, data};
  }
  if (data.starts_with("solid")) return check_text(path, data);
  if (data.size() < kHeader) throw InputError(text(path, ": ", data.size(), " bytes are too few for an STL file"));
  throw InputError(text(path, ": binary STL announces ", n, " triangles (", expected, " bytes) but the file has ",
                        data.size(), " bytes"));
}

}  // namespace kt
