#pragma once
// Temporary files, folders and children of this process: gone when their owner ends, and all at once when the process
// has to end before its owners do.
#include <functional>
#include <string>

namespace kt {

/// A path that is to be gone in the end. The owner says when.
class Leftover {
 public:
  explicit Leftover(std::string path);
  /// What `make` makes, which is not let to leave anything behind when the process ends just then.
  explicit Leftover(const std::function<std::string()>& make);
  ~Leftover();  ///< removes what is there, and all inside
  Leftover(const Leftover&) = delete;
  Leftover& operator=(const Leftover&) = delete;
  void keep();  ///< it has become a result
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  bool is_kept_ = false;
};

/// A child process that leads a group of its own and is waited for.
class LiveChild {
 public:
  explicit LiveChild(int child);  ///< its process number, a pid_t
  ~LiveChild();                   ///< it has ended
  LiveChild(const LiveChild&) = delete;
  LiveChild& operator=(const LiveChild&) = delete;

 private:
  int child_;
};

/// For the thread that ends the process: kills the children, then removes what every Leftover names. No new ones of
/// either are taken from then on.
void remove_leftovers();

}  // namespace kt
