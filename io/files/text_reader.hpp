#pragma once
// A text file with a cursor that knows its line: the strict mesh readers are written on top of it, so that every
// complaint reads "file:line: what, value, allowed".
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.hpp"

namespace kt {

/// Whole content of a regular file. @throws InputError naming the file: missing, directory, unreadable, 0 bytes.
std::string read_whole_file(const std::string& path);

/// `token` as it may appear in a message: quoted, control bytes replaced, at most 40 characters.
std::string in_quotes(std::string_view token);

/// The words of one line, between blanks.
std::vector<std::string_view> split_words(std::string_view line);

/// Equal but for capitals; `lower` is in small letters.
bool equals_any_case(std::string_view word, std::string_view lower);

/// What a number of a file is, for messages: "a coordinate of node 7". Made into text only when there is something to
/// complain about.
struct What {
  std::string_view name;
  long long number = -1;  ///< behind the name; -1: none
  What(const char* words, long long n = -1) : name(words), number(n) {}
  What(std::string_view words, long long n = -1) : name(words), number(n) {}
  What(const std::string& words, long long n = -1) : name(words), number(n) {}
};
std::ostream& operator<<(std::ostream& out, const What& what);

/// Cursor over text made of white-space separated words and `#` comments. Lines end in LF, CR LF or CR.
class TextReader {
 public:
  TextReader(std::string path, std::string data);  ///< a UTF-8 byte order mark at the start is skipped;
                                                   ///< UTF-16 is an InputError

  /// Next word, over line ends and comments; nothing at the end of the file.
  std::optional<std::string_view> word();
  /// Next word of the current line only; nothing at its end.
  std::optional<std::string_view> word_on_line();
  /// Rest of the current line as it stands, comments too, without blanks around it; nothing at the end of the file.
  std::optional<std::string_view> line();
  /// Jumps behind the current line.
  void skip_line();
  /// Forgets NULs at the end of a text, which buffers written whole leave there.
  void drop_last_nuls();
  /// Jumps behind the next `token`; false when there is none.
  bool skip_past(std::string_view token);

  /// The next word as a number. @throws InputError naming `what` when it is missing or is no number.
  double number(const What& what, bool allow_non_finite = false);
  long long integer(const What& what);
  /// The same of a coordinate, which must be below kLargestCoordinate.
  double coordinate(const What& what, bool allow_non_finite = false);

  /// An announced number of records, each of at least `bytes_each` bytes: refused when the rest of the file cannot hold
  /// it, so that a wrong header never allocates.
  int count(std::string_view what, std::size_t bytes_each);
  void check_count(long long n, std::string_view what, std::size_t bytes_each) const;

  double to_number(std::string_view token, const What& what, bool allow_non_finite = false) const;
  double to_coordinate(std::string_view token, const What& what, bool allow_non_finite = false) const;
  long long to_integer(std::string_view token, const What& what) const;

  /// Throws InputError "file:line: ...".
  template <class... Args>
  [[noreturn]] void fail(const Args&... args) const {
    fail_at(line_, args...);
  }
  template <class... Args>
  [[noreturn]] void fail_at(int line_number, const Args&... args) const {
    throw InputError(text(path_, ":", line_number, ": ", args...));
  }

  int line_number() const { return line_; }      ///< of the last word or line handed out, from 1
  void say_line(int number) { line_ = number; }  ///< what complaints name until the next word or line
  const std::string& path() const { return path_; }
  std::size_t position() const { return at_; }  ///< of the cursor, bytes from the start of the file
  std::size_t bytes_left() const { return data_.size() - at_; }
  std::string_view rest() const { return std::string_view(data_).substr(at_); }
  void skip_bytes(std::size_t n) { at_ += n; }

  /// A place to come back to.
  struct Bookmark {
    std::size_t at;
    int line;
  };
  Bookmark bookmark() const { return {at_, next_line_}; }
  void go_back(const Bookmark& place);

 private:
  std::size_t break_length(std::size_t at) const;
  void skip_blanks();

  std::string path_, data_;
  bool lone_returns_ = false;  ///< lines end in CR alone, so that an LF behind one is data
  std::size_t at_ = 0;
  int line_ = 1;       ///< line of at_, except after line(): of what it handed out
  int next_line_ = 1;  ///< line of at_
};

/// Coordinates from here on are refused: their squares and products are no numbers any more.
inline constexpr double kLargestCoordinate = 1e100;

}  // namespace kt
