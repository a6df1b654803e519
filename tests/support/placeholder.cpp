#include "core/mesh.hpp"
