#pragma once
#include <string>

namespace kt {

struct CheckedPly {
  long long vertices = 0, faces = 0;
  std::string data;  ///< the file with its header written anew, in the plainest words
};

/// Walks a whole PLY file before the library may see it: OpenMesh 9 loops for ever on some bad headers and takes cut or
/// garbled bodies without a word. @throws InputError "file:line: ..." (binary bodies: element and number).
CheckedPly check_ply(const std::string& path, const std::string& data);

}  // namespace kt
