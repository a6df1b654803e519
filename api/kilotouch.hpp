#pragma once
// The front door, with everything that a program around the engine needs. Headers that it does not include are not
// installed.
//
//   kt::Body body(options) or kt::Body(std::make_unique<MyModel>(...));   // the touched body
//   kt::Touch touch(body, options);                                      // tools and settings
//   touch.place(pose); touch.start();                                    // the body in a thread of its own
//   const kt::LocalFrame& f = touch.tick(pose);                          // your loop and clock, with force, torque,
//   flags
//
// docs/embedding.md has the rest. The C interface is kilotouch.h.
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

const char* version() noexcept;  ///< version of the library, "0.2.0"

}  // namespace kt
