#include "core/error.hpp"
#include "io/tetrahedralize_backends.hpp"
namespace kt {
Mesh tetrahedralize_netgen(const Mesh&, const TetrahedralizeOptions&) { throw RunError("netgen: not written yet"); }
}
