#include "apps/check/library.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "core/error.hpp"
#include "io/mesh_io.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

bool is_mesh(const fs::path& file) {
  const std::string extension = mesh_extension(file.string());
  if (file.filename().string().starts_with("._")) return false;  // what a Mac keeps beside a file
  // A TetGen pair is one mesh, known by its .node file.
  return extension != ".ele" && std::ranges::count(readable_mesh_extensions(), extension) > 0;
}

void add_folder(const fs::path& folder, const std::string& prefix, std::vector<LibraryMesh>& out) {
  const std::size_t before = out.size();
  const auto options = fs::directory_options::follow_directory_symlink | fs::directory_options::skip_permission_denied;
  for (const auto& entry : fs::recursive_directory_iterator(folder, options)) {
    std::error_code none;
    if (!is_mesh(entry.path()) || entry.is_directory(none)) continue;
    out.push_back(
        {prefix + entry.path().lexically_relative(folder).generic_string(), fs::absolute(entry.path()).string()});
  }
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
      out.push_back({place.filename().string(), fs::absolute(place).string()});
  }
  std::ranges::sort(out, {}, &LibraryMesh::key);
  const auto same = std::ranges::adjacent_find(out, {}, &LibraryMesh::key);
  if (same != out.end())
    throw InputError(text("two meshes would be called ", same->key, ": ", same->file, " and ", std::next(same)->file,
                          "; check them apart, or give the folder above"));
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
