#pragma once
// The folder of a result: asked for before the work, and nobody else's until the end.
#include <filesystem>
#include <string>
#include <vector>

namespace kt {

enum class FolderUse { alone, shared };

/// Made, tried and locked while this lives. Folders that it made and nothing was written to are removed.
class OutputFolder {
 public:
  /// @param told   names it in messages: "--out DIR"
  /// @param names  of files that will be written there
  /// @param use    shared: with others that say so too
  /// @throws InputError: it cannot be made or written to, something else lies in a file's place, another process has it
  OutputFolder(const std::string& path, const std::string& told, const std::vector<std::string>& names = {},
               FolderUse use = FolderUse::alone);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  struct Made {
    explicit Made(const std::string& path);
    ~Made();
    std::vector<std::filesystem::path> folders;  ///< the innermost first
  } made_;
  int lock_ = -1;
};

}  // namespace kt
