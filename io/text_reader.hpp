#pragma once
// A text file with a cursor that knows its line: the strict mesh readers are written on top of it, so that every
// complaint reads "file:line: what, value, allowed".
#include <optional>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace kt {

/// Whole content of a regular file. @throws InputError naming the file: missing, directory, unreadable, 0 bytes.
std::string read_whole_file(const std::string& path);

/// `token` as it may appear in a message: quoted, control bytes replaced, at most 40 characters.
std::string quoted(std::string_view token);

/// Cursor over text made of white-space separated words and `#` comments.
class TextReader {
 public:
  TextReader(std::string path, std::string data);  ///< a UTF-8 byte order mark at the start is skipped;
                                                   ///< UTF-16 is an InputError

  /// Next word, over line ends and comments; nothing at the end of the file.
  std::optional<std::string_view> word();
  /// Next word of the current line only; nothing at its end.
  std::optional<std::string_view> word_on_line();
  /// Next non-blank line without its comment; `\` at a line's end joins it with the next one.
  std::optional<std::string_view> line();
  /// Jumps behind the current line.
  void skip_line();

  /// The next word as a number. @throws InputError naming `what` when it is missing or is no number.
  double number(std::string_view what, bool allow_non_finite = false);
  long long integer(std::string_view what);

  /// An announced number of records, each of at least `bytes_each` bytes: refused when the rest of the file cannot hold
  /// it, so that a wrong header never allocates.
  int count(std::string_view what, std::size_t bytes_each);
  void check_count(long long n, std::string_view what, std::size_t bytes_each) const;

  double to_number(std::string_view token, std::string_view what, bool allow_non_finite = false) const;
  long long to_integer(std::string_view token, std::string_view what) const;

  /// Throws InputError "file:line: ...".
  template <class... Args>
  [[noreturn]] void fail(const Args&... args) const {
    fail_at(line_, args...);
  }
  template <class... Args>
  [[noreturn]] void fail_at(int line_number, const Args&... args) const {
    throw InputError(text(path_, ":", line_number, ": ", args...));
  }

  int line_number() const { return line_; }  ///< of the last word or line handed out, from 1
  const std::string& path() const { return path_; }
  std::size_t bytes_left() const { return data_.size() - at_; }
  std::string_view rest() const { return std::string_view(data_).substr(at_); }
  void skip_bytes(std::size_t n) { at_ += n; }

 private:
  void skip_blanks();

  std::string path_, data_, joined_;
  std::size_t at_ = 0;
  int line_ = 1;       ///< line of at_, except after line(): the first line of what it handed out
  int next_line_ = 1;  ///< line of at_, for line()
};

}  // namespace kt
