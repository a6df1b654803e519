#pragma once
#include <string>

namespace kt {

struct CheckedStl {
  long long faces = 0;
  std::string data;  ///< the same triangles as a plain binary file
};

/// Reads a whole STL file and writes it anew before the library may see it: OpenMesh 9 takes a text file line by line,
/// whatever stands there, and joins a corner that is NaN with any other.
/// @throws InputError for a file that is cut or garbled, and for coordinates that are not finite 32-bit floats.
CheckedStl check_stl(const std::string& path, const std::string& data);

}  // namespace kt
