#pragma once
// What a page may say: JSON text, looked at field by field before anything is done with it.
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

struct PageMessage {
  enum class Kind {
    target,   ///< the pointer's place: x, number, stamp
    set,      ///< a setting while it runs: settings[0] = "key=value"
    restart,  ///< the scene anew with these settings, "key=value"
    check,    ///< the same, only looked at: what would be wrong with it
    open,     ///< another scene, or the mesh that was uploaded: name; on: repaired first
    reset,
    pause,   ///< on
    record,  ///< on
    cancel,  ///< the body that is being built for a restart or an open
    take,    ///< the tool, from the page that has it
    seek     ///< a session: stamp is the time [s]
  };
  Kind kind = Kind::target;
  Vec3 x = Vec3::Zero();
  unsigned number = 0;
  double stamp = 0;
  bool on = false;
  std::string name{};
  std::vector<std::string> settings{};
};

constexpr std::size_t kLongestMessage = 65536;  // bytes

/// @throws InputError, one line: what is wrong with it
PageMessage parse_page_message(const std::string& message);

}  // namespace kt
