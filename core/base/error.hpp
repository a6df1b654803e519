#pragma once
// Errors that a user can cause, as one line with the quantity, its place, its value and the allowed range.
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace kt {

/// Wrong input, as a file, a key, a name or a value. The command line turns it into exit code 2 and prints its text
/// alone.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A call at the wrong time, or with the wrong number of things. The cure is in the calling program, not in its input.
class MisuseError : public InputError {
 public:
  using InputError::InputError;
};

/// The run itself failed (diverged, gave up). Exit code 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A linearized body that gives way to some motion, as a compressed one can. It cannot be stepped at a fixed rate. Its
/// definite tangent can (TangentKind).
class IndefiniteTangent : public RunError {
 public:
  using RunError::RunError;
};

/// All arguments written one after the other, as operator<< writes them in the classic locale.
template <class... Args>
std::string text(const Args&... args) {
  std::ostringstream out;
  out.imbue(std::locale::classic());  // the host program may have set another global one
  (out << ... << args);
  return out.str();
}

/// "a, b, c" for messages that list the known names.
std::string join(const std::vector<std::string>& names);

/// The known name nearest to `name` (edit distance), for "did you mean". Empty when nothing is near.
std::string nearest_name(const std::string& name, const std::vector<std::string>& known);

/// Throws InputError with the unknown name, its kind, the nearest known name and all known ones.
[[noreturn]] void throw_unknown(const std::string& what, const std::string& name,
                                const std::vector<std::string>& known);

}  // namespace kt

/// Our own mistakes. Checked in Debug and in all tests, free in Release.
#ifdef NDEBUG
#define KT_ASSERT(condition) ((void)0)
#else
#include <cassert>
#define KT_ASSERT(condition) assert(condition)
#endif
