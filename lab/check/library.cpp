#include "lab/check/library.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <set>

#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

bool is_mesh(const fs::path& file) {
  const std::string extension = mesh_extension(file.string());
  if (file.filename().string().starts_with("._")) return false;  // what a Mac keeps beside a file
  // A TetGen pair is one mesh, known by its .node file.
  return extension != ".ele" && std::ranges::count(readable_mesh_extensions(), extension) > 0;
}

/// A folder by what it is, not by the links that lead to it.
using FolderId = std::pair<dev_t, ino_t>;

std::optional<FolderId> folder_id(const fs::path& folder) {
  struct stat found {};
  if (::stat(folder.c_str(), &found) != 0) return {};
  return FolderId{found.st_dev, found.st_ino};
}

/// Walks below a folder and enters each once: a link to one that was entered, or to one above, leads nowhere new.
class FolderWalk {
 public:
  explicit FolderWalk(const fs::path& root) {
    for (fs::path above = fs::canonical(root); above.has_relative_path();) {
      above = above.parent_path();
      if (const auto id = folder_id(above)) seen_.insert(*id);
    }
    enter(root);
    // Links after all real folders, so that a name never depends on the order of a folder's entries.
    for (std::size_t i = 0; i < links_.size(); ++i) enter(fs::path(links_[i]));
  }
  const std::vector<fs::path>& files() const { return files_; }

 private:
  void enter(const fs::path& folder) {
    const auto id = folder_id(folder);
    if (!id || !seen_.insert(*id).second) return;
    std::vector<fs::path> inside;
    std::error_code none;
    for (auto it = fs::directory_iterator(folder, fs::directory_options::skip_permission_denied, none);
         !none && it != fs::directory_iterator(); it.increment(none))
      inside.push_back(it->path());
    std::ranges::sort(inside);
    for (const fs::path& path : inside) {
      if (!fs::is_directory(path, none))
        files_.push_back(path);
      else if (fs::is_symlink(path, none))
        links_.push_back(path);
      else
        enter(path);
    }
  }
  std::set<FolderId> seen_;
  std::vector<fs::path> files_, links_;
};

void add_folder(const fs::path& folder, const std::string& prefix, std::vector<LibraryMesh>& out) {
  const std::size_t before = out.size();
  const FolderWalk walk(folder);
  for (const fs::path& file : walk.files())
    if (is_mesh(file))
      out.push_back(
          {escape_bytes(prefix + file.lexically_relative(folder).generic_string()), fs::absolute(file).string()});
  if (out.size() == before)
    throw InputError(text(folder.string(), ": no mesh files in it; known: ", join(readable_mesh_extensions())));
}

}  // namespace

std::vector<LibraryMesh> find_meshes(const std::vector<std::string>& paths) {
  std::vector<LibraryMesh> out;
  for (const std::string& path : paths) {
    fs::path place = fs::path(path).lexically_normal();
    if (!place.has_filename()) place = place.parent_path();  // "folder/"
    if (!fs::exists(place)) throw InputError(path + ": no such file or folder");
    if (fs::is_directory(place))
      add_folder(place, paths.size() > 1 ? fs::absolute(place).lexically_normal().filename().string() + "/" : "", out);
    else
      out.push_back({escape_bytes(place.filename().string()), fs::absolute(place).string()});
  }
  std::ranges::sort(out, {}, &LibraryMesh::key);
  const auto same = std::ranges::adjacent_find(out, {}, &LibraryMesh::key);
  if (same != out.end())
    throw InputError(text("two meshes would be called ", same->key, ": ", same->file, " and ", std::next(same)->file,
                          "; check them apart, or give the folder above"));
  return out;
}

std::vector<std::string> files_of(const std::string& mesh) {
  std::vector<std::string> out{mesh};
  if (mesh_extension(mesh) != ".node") return out;
  const fs::path small = fs::path(mesh).replace_extension(".ele"), large = fs::path(mesh).replace_extension(".ELE");
  out.push_back((fs::exists(large) && !fs::exists(small) ? large : small).string());
  return out;
}

Shard parse_shard(const std::string& words) {
  Shard out{0, 0};
  const char* end = words.data() + words.size();
  const auto [slash, bad_index] = std::from_chars(words.data(), end, out.index);
  if (bad_index == std::errc() && slash != end && *slash == '/') {
    const auto [rest, bad_count] = std::from_chars(slash + 1, end, out.count);
    if (bad_count == std::errc() && rest == end && out.index >= 1 && out.index <= out.count) return out;
  }
  throw InputError(text("--shard ", words, ": must be I/N with I in 1 .. N, as 2/8"));
}

std::vector<LibraryMesh> part_of(const std::vector<LibraryMesh>& all, const Shard& shard) {
  std::vector<LibraryMesh> out;
  for (std::size_t i = static_cast<std::size_t>(shard.index - 1); i < all.size();
       i += static_cast<std::size_t>(shard.count))
    out.push_back(all[i]);
  return out;
}

}  // namespace kt
