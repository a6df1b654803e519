#include "collision/broad/triangle_index.hpp"

namespace kt {

#define TRIANGLE_INDEX(name, available, option, what) std::unique_ptr<TriangleIndex> make_##name##_triangle_index();
#include "collision/broad/triangle_index.def"

// A backend that is not in this build must not be asked for by the linker.
#define KT_MAKE_IF_1(name) return make_##name##_triangle_index();
#define KT_MAKE_IF_0(name)
#define KT_MAKE_IF(available, name) KT_MAKE_IF_(available, name)
#define KT_MAKE_IF_(available, name) KT_MAKE_IF_##available(name)

std::vector<BackendInfo> triangle_index_backends() {
  return {
#define TRIANGLE_INDEX(name, available, option, what) {#name, what, available != 0, option},
#include "collision/broad/triangle_index.def"
  };
}

std::unique_ptr<TriangleIndex> make_triangle_index(const std::string& name) {
  require_backend("collision.backend", name, triangle_index_backends());
#define TRIANGLE_INDEX(known, available, option, what) \
  if (name == #known) {                                \
    KT_MAKE_IF(available, known)                       \
  }
#include "collision/broad/triangle_index.def"
  return nullptr;
}

}  // namespace kt
