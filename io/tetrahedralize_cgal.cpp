#include "core/error.hpp"
#include "io/tetrahedralize_backends.hpp"
namespace kt {
Mesh tetrahedralize_cgal(const Mesh&, const TetrahedralizeOptions&) { throw RunError("cgal: not written yet"); }
}
