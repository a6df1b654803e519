#include "haptics/contact/contact_solver.hpp"

#include <limits>

namespace kt {

#define CONTACT_SOLVER(name, available, option, what) \
  std::unique_ptr<ContactSolver> make_##name##_solver(SurfaceFriction friction);
#include "haptics/contact/contact_solver.def"

const char* name_of(ContactMode mode) {
  constexpr const char* kNames[] = {"free", "stick", "slide", "frictional_slide"};
  return kNames[static_cast<int>(mode)];
}

namespace {

void check(const Friction& f) {
  if (!(f.mu_kinetic >= 0 && f.mu_static >= f.mu_kinetic && f.mu_static < std::numeric_limits<double>::infinity()))
    throw InputError(text("contact: mu_static = ", f.mu_static, ", mu_kinetic = ", f.mu_kinetic,
                          ": must satisfy 0 <= mu_kinetic <= mu_static"));
  if (!(f.stribeck >= 0 && f.stribeck < std::numeric_limits<double>::infinity()))
    throw InputError(text("contact: stribeck = ", f.stribeck, " m/s: must be a finite number, at least 0"));
}

}  // namespace

std::vector<BackendInfo> contact_solver_backends() {
  return {
#define CONTACT_SOLVER(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/contact/contact_solver.def"
  };
}

std::unique_ptr<ContactSolver> make_contact_solver(const std::string& law, const Friction& friction,
                                                   std::vector<Friction> of_triangle) {
  require_backend("contact.law", law, contact_solver_backends());
  check(friction);
  for (const Friction& f : of_triangle) check(f);
  SurfaceFriction surface{friction, std::move(of_triangle)};
#define CONTACT_SOLVER(name, available, option, what) \
  if (law == #name) return make_##name##_solver(std::move(surface));
#include "haptics/contact/contact_solver.def"
  return nullptr;
}

}  // namespace kt
