#pragma once
#include <array>

namespace kt {

/// Where people feel: at rest, slow pressing, tremor, vibration. [Hz]
inline constexpr std::array<double, 7> kCertifiedHz{0, 10, 30, 50, 100, 200, 500};

}  // namespace kt
