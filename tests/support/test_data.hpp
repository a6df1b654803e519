#pragma once
// Real meshes and collision queries, which are not in the repository. Every test must also pass where they are absent.
#include <cstdlib>
#include <string>

namespace kt {

/// Their folder: KT_TEST_DATA of the environment, else the build's. It may not be there; tests of nothing else skip
/// then.
inline std::string test_data() {
  const char* const other = std::getenv("KT_TEST_DATA");
  return other ? other : KT_TEST_DATA;
}

}  // namespace kt
