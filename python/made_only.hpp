#pragma once
// An object of which only __new__ was called, as by copyreg, has no value yet: pybind11 would hand out memory that
// nobody has filled. Here it is of the wrong type instead.
#include <pybind11/pybind11.h>

namespace kt {

template <class T>
class MadeOnly : public pybind11::detail::type_caster_base<T> {
 public:
  bool load(pybind11::handle given, bool convert) {
    const auto* const type = pybind11::detail::get_type_info(typeid(T));
    if (type && given && PyObject_TypeCheck(given.ptr(), type->type) != 0) {
      auto* const instance = reinterpret_cast<pybind11::detail::instance*>(given.ptr());
      if (!instance->get_value_and_holder(type).holder_constructed()) return false;
    }
    return pybind11::detail::type_caster_base<T>::load(given, convert);
  }
};

}  // namespace kt

/// For a class that is bound, in every file that takes one.
#define KT_MADE_ONLY(Class) \
  template <>               \
  class pybind11::detail::type_caster<Class> : public kt::MadeOnly<Class> {}
