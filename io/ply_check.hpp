#pragma once
#include <string>

namespace kt {

struct CheckedPly {
  long long vertices = 0, faces = 0;
  std::string data;  ///< the same vertices and faces as a plain binary file of 32-bit floats and integers
};

/// Reads a whole PLY file and writes it anew before the library may see it: OpenMesh 9 loops for ever on some bad
/// headers, takes cut or garbled bodies without a word, and loses its place at lists, comments and words like "nan".
/// @throws InputError "file:line: ..." (binary bodies: element and number).
CheckedPly check_ply(const std::string& path, const std::string& data);

}  // namespace kt
