#pragma once
// The front door: everything that a program around the engine needs. What is not included here is not installed.
//
//   kt::Body body(options) or kt::Body(std::make_unique<MyModel>(...));   // what is touched
//   kt::Touch touch(body, options);                                      // by what, and how
//   touch.place(pose); touch.start();                                    // the body in a thread of its own
//   const kt::LocalFrame& f = touch.tick(pose);                          // your loop, your clock: force, torque, flags
//
// docs/embedding.md says the rest. The C interface is kilotouch.h.
#include "collision/shape/tool_shape.hpp"
#include "core/base/error.hpp"
#include "core/body/check_model.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/guard/safety_chain.hpp"
#include "haptics/touch/touch.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/scene/scene.hpp"

#define KILOTOUCH_VERSION_MAJOR 0
#define KILOTOUCH_VERSION_MINOR 2
#define KILOTOUCH_VERSION_PATCH 0

namespace kt {

const char* version() noexcept;  ///< of the library: "0.2.0"

}  // namespace kt
