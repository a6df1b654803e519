#pragma once
// A file that the user has named is written by one process at a time.
#include <string>

namespace kt {

/// Held until it goes, or the process ends in whatever way; nothing lies beside the file meanwhile. Known to processes
/// of the same user on this computer. Devices, pipes and standard output ("-") may be shared.
class FileClaim {
 public:
  /// @param told  names it in the message, as "--json FILE"
  /// @throws InputError where another one holds it
  FileClaim(const std::string& path, const std::string& told);
  ~FileClaim();
  FileClaim(FileClaim&& other) noexcept;
  FileClaim& operator=(FileClaim&&) = delete;

 private:
  int socket_ = -1;
};

}  // namespace kt
