#pragma once
// The meshes of a check: which files, under which names, and whose part they are.
#include <string>
#include <vector>

namespace kt {

struct LibraryMesh {
  std::string key;   ///< names it in reports: its path from the folder given, the same on every machine; UTF-8, other
                     ///< bytes of the path escaped (core/base/visible_text.hpp)
  std::string file;  ///< absolute
};

/// All mesh files below the folders and the files given, ascending by key. Links are followed, but no folder is entered
/// twice, nor one above a folder given. Of several folders each key begins with the
/// folder's name.
/// @throws InputError for a path that is not there, holds no mesh, or two meshes of one key
std::vector<LibraryMesh> find_meshes(const std::vector<std::string>& paths);

/// The files of a mesh: of a TetGen pair both.
std::vector<std::string> files_of(const std::string& mesh);

/// Part `index` of `count`, from 1.
struct Shard {
  int index = 1, count = 1;
};
/// "3/8". Throws InputError.
Shard parse_shard(const std::string& words);
/// Every count-th mesh: each is in exactly one part, whatever the machine.
std::vector<LibraryMesh> part_of(const std::vector<LibraryMesh>& all, const Shard& shard);

}  // namespace kt
