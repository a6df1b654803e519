#include <zlib.h>

#include "core/base/error.hpp"
#include "io/mesh/format/inflate.hpp"

namespace kt {

void append_inflated(std::string_view compressed, std::size_t size, std::string& out) {
  constexpr std::size_t kMostRatio = 1032;  // of deflate
  if (size / kMostRatio > compressed.size())
    throw InputError(text(compressed.size(), " compressed bytes cannot stand for ", size));
  const std::size_t begin = out.size();
  out.resize(begin + size);
  auto length = static_cast<uLongf>(size);
  const int result =
      uncompress(reinterpret_cast<Bytef*>(out.data() + begin), &length,
                 reinterpret_cast<const Bytef*>(compressed.data()), static_cast<uLong>(compressed.size()));
  if (result != Z_OK || length != size)
    throw InputError(text("compressed data that are garbled or cut (zlib: ", zError(result), ")"));
}

}  // namespace kt
