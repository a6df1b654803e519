#include "io/files/leftovers.hpp"

#include <signal.h>

#include <chrono>
#include <filesystem>
#include <mutex>
#include <set>
#include <thread>

namespace kt {
namespace {

struct Known {
  std::mutex mutex;
  std::set<std::string> paths;
  std::set<pid_t> children;
};

/// Outlives every owner: not destroyed at the end of the process.
Known& known() {
  static Known* const all = new Known;
  return *all;
}

void remove(const std::string& path) {
  std::error_code ignored;
  std::filesystem::remove_all(path, ignored);
}

}  // namespace

Leftover::Leftover(std::string path) : path_(std::move(path)) {
  const std::lock_guard lock(known().mutex);
  known().paths.insert(path_);
}

Leftover::Leftover(const std::function<std::string()>& make) {
  const std::lock_guard lock(known().mutex);  // a process that ends has it for good
  path_ = make();
  known().paths.insert(path_);
}

Leftover::~Leftover() {
  if (!is_kept_) remove(path_);
  const std::lock_guard lock(known().mutex);
  known().paths.erase(path_);
}

void Leftover::keep() { is_kept_ = true; }

LiveChild::LiveChild(int child) : child_(child) {
  const std::lock_guard lock(known().mutex);
  known().children.insert(child_);
}

LiveChild::~LiveChild() {
  const std::lock_guard lock(known().mutex);
  known().children.erase(child_);
}

void remove_leftovers() {
  known().mutex.lock();  // for good
  for (const pid_t child : known().children) {
    ::kill(-child, SIGKILL);
    ::kill(child, SIGKILL);  // in case it has not yet made its own group
  }
  // A killed process may still hold a file for a moment, and make one while its folder is emptied.
  for (int i = 0; i < 10; ++i) {
    std::error_code none;
    bool is_left = false;
    for (const std::string& path : known().paths) {
      remove(path);
      is_left = is_left || std::filesystem::exists(path, none);
    }
    if (!is_left && i > 0) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace kt
