#pragma once
// A stand-in of a maker's library, and the device behind it.
#include <dlfcn.h>

#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "haptics/driver/device_slots.hpp"
#include "tests/fakes/fake_device.hpp"

namespace kt::fake {

inline std::string library(const std::string& name) { return std::string(KT_FAKES) + "/" + name; }

/// Of libHD.so or libdhd.so, as whoever loads that file in this process sees it.
inline Device& device(const std::string& name) {
  void* const loaded = dlopen(library(name).c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (!loaded) throw std::runtime_error(dlerror());
  Device& out = *reinterpret_cast<Device* (*)()>(dlsym(loaded, "fake_device"))();
  out.fault = Fault::none;
  out.count = 1;
  out.buttons = 0;
  out.forces_off = 0;
  out.wrong = -1;
  out.styles = 4;
  for (auto& x : out.x) x = 0;
  return out;
}

/// Waits until it is so, 5 s at most.
inline bool becomes(const std::function<bool()>& is_so) {
  for (int i = 0; i < 5000; ++i) {
    if (is_so()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace kt::fake
