#pragma once
// What an InputError says.
#include <functional>
#include <string>

#include "core/base/error.hpp"

namespace kt {

inline std::string message(const std::function<void()>& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no InputError";
}

}  // namespace kt
