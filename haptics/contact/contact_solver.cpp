#include "haptics/contact/contact_solver.hpp"

namespace kt {

#define CONTACT_SOLVER(name, available, option, what) \
  std::unique_ptr<ContactSolver> make_##name##_solver(const Friction& friction);
#include "haptics/contact/contact_solver.def"
#undef CONTACT_SOLVER

const char* name_of(ContactMode mode) {
  constexpr const char* kNames[] = {"free", "stick", "slide", "frictional_slide"};
  return kNames[static_cast<int>(mode)];
}

std::vector<BackendInfo> contact_solver_backends() {
  return {
#define CONTACT_SOLVER(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/contact/contact_solver.def"
#undef CONTACT_SOLVER
  };
}

std::unique_ptr<ContactSolver> make_contact_solver(const std::string& law, const Friction& friction) {
  require_backend("contact.law", law, contact_solver_backends());
  if (!(friction.mu_kinetic >= 0 && friction.mu_static >= friction.mu_kinetic))
    throw InputError(text("contact: mu_static = ", friction.mu_static, ", mu_kinetic = ", friction.mu_kinetic,
                          ": must satisfy 0 <= mu_kinetic <= mu_static"));
#define CONTACT_SOLVER(name, available, option, what) \
  if (law == #name) return make_##name##_solver(friction);
#include "haptics/contact/contact_solver.def"
#undef CONTACT_SOLVER
  return nullptr;
}

}  // namespace kt
