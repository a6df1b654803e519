#include "io/files/text_reader.hpp"
#include "core/base/numbers.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>

namespace kt {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

}  // namespace

std::string read_whole_file(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(text(path, ": no such file"));
  if (fs::is_directory(status)) throw InputError(text(path, ": is a directory, not a file"));
  if (!fs::is_regular_file(status)) throw InputError(text(path, ": is not a regular file"));
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw InputError(text(path, ": cannot be read: ", error.message()));
  if (size == 0) throw InputError(text(path, ": file is empty (0 bytes)"));
  constexpr std::uintmax_t kLargest = std::uintmax_t{4} << 30;  // beyond int indices and any interactive use
  if (size > kLargest)
    throw InputError(text(path, ": file has ", size, " bytes, more than the ", kLargest, " allowed"));
  // Between the look above and here, a pipe may have taken its place: it would be waited for.
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (file < 0) throw InputError(text(path, ": cannot be read: ", std::strerror(errno)));
  std::string data(static_cast<std::size_t>(size), '\0');
  std::size_t done = 0;
  ssize_t n = 1;
  while (done < data.size() && (n = ::read(file, data.data() + done, data.size() - done)) > 0)
    done += static_cast<std::size_t>(n);
  ::close(file);
  if (done < data.size()) throw InputError(text(path, ": cannot be read to its end"));
  return data;
}

std::string in_quotes(std::string_view token) {
  std::string out = "\"";
  for (const char c : token.substr(0, 40)) out += (c >= ' ' && c < 127) ? c : '?';
  return out + (token.size() > 40 ? "...\"" : "\"");
}

std::vector<std::string_view> split_words(std::string_view line) {
  constexpr const char* kBlanks = " \t\v\f";
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = line.find_first_not_of(kBlanks, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

bool equals_any_case(std::string_view word, std::string_view lower_word) {
  return std::equal(word.begin(), word.end(), lower_word.begin(), lower_word.end(),
                    [](char a, char b) { return lower(a) == b; });
}

namespace {

/// Of a word that is a number: with the range of a long double; beyond it 0 or infinite.
long double long_number(std::string_view word) {
  long double value = 0;
  if (std::from_chars(word.data(), word.data() + word.size(), value).ec == std::errc()) return value;
  const std::size_t e = word.find_first_of("eE");
  const bool is_tiny = e + 1 < word.size() && word[e + 1] == '-';
  return is_tiny || e == std::string_view::npos ? 0 : std::numeric_limits<long double>::infinity();
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const What& what) {
  out << what.name;
  return what.number < 0 ? out : out << ' ' << what.number;
}

TextReader::TextReader(std::string path, std::string data) : path_(std::move(path)), data_(std::move(data)) {
  if (data_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  if (data_.starts_with("\xFF\xFE") || data_.starts_with("\xFE\xFF"))
    throw InputError(text(path_, ": the file is UTF-16 text; must be ASCII or UTF-8 (save it so)"));
  const std::size_t first = data_.find_first_of("\r\n");
  lone_returns_ = first != std::string::npos && data_[first] == '\r' && data_.find('\n', first) > first + 2;
}

/// Bytes of the line's end that stands at `at`; 0 when there is none. Files that went through several systems also have
/// CR CR LF.
std::size_t TextReader::break_length(std::size_t at) const {
  if (data_[at] == '\n') return 1;
  if (data_[at] != '\r') return 0;
  if (lone_returns_) return 1;
  return data_.compare(at, 2, "\r\n") == 0 ? 2 : data_.compare(at, 3, "\r\r\n") == 0 ? 3 : 1;
}

void TextReader::skip_blanks() {
  while (at_ < data_.size() && is_blank(data_[at_])) ++at_;
  if (at_ < data_.size() && data_[at_] == '#')
    while (at_ < data_.size() && break_length(at_) == 0) ++at_;
}

std::optional<std::string_view> TextReader::word_on_line() {
  line_ = next_line_;  // line() may have been used before
  skip_blanks();
  if (at_ == data_.size() || break_length(at_) > 0) return std::nullopt;
  const std::size_t begin = at_;
  while (at_ < data_.size() && !is_space(data_[at_]) && data_[at_] != '#') ++at_;
  return std::string_view(data_).substr(begin, at_ - begin);
}

std::optional<std::string_view> TextReader::word() {
  for (;;) {
    if (auto found = word_on_line()) return found;
    if (at_ == data_.size()) return std::nullopt;
    skip_line();
  }
}

void TextReader::skip_line() {
  line();
  line_ = next_line_;
}

std::optional<std::string_view> TextReader::line() {
  line_ = next_line_;
  if (at_ == data_.size()) return std::nullopt;
  const std::size_t begin = at_;
  while (at_ < data_.size() && break_length(at_) == 0) ++at_;
  std::string_view out = std::string_view(data_).substr(begin, at_ - begin);
  if (at_ < data_.size()) {
    at_ += break_length(at_);
    ++next_line_;
  }
  while (!out.empty() && is_blank(out.back())) out.remove_suffix(1);
  while (!out.empty() && is_blank(out.front())) out.remove_prefix(1);
  return out;
}

void TextReader::drop_last_nuls() {
  while (data_.size() > at_ && data_.back() == '\0') data_.pop_back();
}

bool TextReader::skip_past(std::string_view token) {
  const std::size_t found = data_.find(token, at_);
  const std::size_t end = found == std::string::npos ? data_.size() : found + token.size();
  while (at_ < end) {
    const std::size_t step = break_length(at_);
    next_line_ += step > 0;
    at_ += std::max<std::size_t>(step, 1);
  }
  at_ = end;
  line_ = next_line_;
  return found != std::string::npos;
}

void TextReader::go_back(const Bookmark& place) {
  at_ = place.at;
  line_ = next_line_ = place.line;
}

double TextReader::to_number(std::string_view token, const What& what, bool allow_non_finite) const {
  const char* first = token.data();
  const char* const last = first + token.size();
  if (token.size() > 1 && *first == '+' && first[1] != '-') ++first;
  double value = 0;
  auto [end, error] = std::from_chars(first, last, value);
  if (error == std::errc::result_out_of_range && end == last) {
    value = static_cast<double>(long_number({first, last}));  // tells 1e-999 (0, fine) from 1e999 (inf)
    if (!std::isfinite(value)) fail(what, " ", in_quotes(token), " is beyond the range of a double (1.8e308)");
  } else if (error != std::errc() || end != last) {
    fail(what, " ", in_quotes(token), " is not a number");
  }
  if (!std::isfinite(value) && !allow_non_finite) fail(what, " is ", in_quotes(token), "; must be finite");
  return value;
}

double TextReader::to_coordinate(std::string_view token, const What& what, bool allow_non_finite) const {
  const double value = to_number(token, what, allow_non_finite);
  if (std::isfinite(value) && std::abs(value) >= kLargestCoordinate)
    fail(what, " is ", in_quotes(token), "; must be below ", kLargestCoordinate);
  return value;
}

long long TextReader::to_integer(std::string_view token, const What& what) const {
  const char* first = token.data();
  const char* const last = first + token.size();
  if (token.size() > 1 && *first == '+' && first[1] != '-') ++first;
  long long value = 0;
  auto [end, error] = std::from_chars(first, last, value);
  if (error == std::errc::result_out_of_range) fail(what, " ", in_quotes(token), " is too large for an integer");
  if (error != std::errc() || end != last) fail(what, " ", in_quotes(token), " is not an integer");
  return value;
}

double TextReader::number(const What& what, bool allow_non_finite) {
  const auto found = word();
  if (!found) fail("file ends where ", what, " should be");
  return to_number(*found, what, allow_non_finite);
}

double TextReader::coordinate(const What& what, bool allow_non_finite) {
  const auto found = word();
  if (!found) fail("file ends where ", what, " should be");
  return to_coordinate(*found, what, allow_non_finite);
}

long long TextReader::integer(const What& what) {
  const auto found = word();
  if (!found) fail("file ends where ", what, " should be");
  return to_integer(*found, what);
}

void TextReader::check_count(long long n, std::string_view what, std::size_t bytes_each) const {
  if (n < 0) fail("number of ", what, " is ", n, "; must be at least 0");
  constexpr long long kMost = std::numeric_limits<int>::max() / 4;  // 3n and 4n stay ints
  if (n > kMost) fail("header announces ", n, " ", what, "; at most ", kMost, " are possible");
  const std::size_t possible = bytes_left() / bytes_each + 1;  // the last record may lack its line end
  if (static_cast<std::size_t>(n) > possible)
    fail("header announces ", n, " ", what, ", but the ", bytes_left(), " bytes that follow hold at most ", possible);
}

int TextReader::count(std::string_view what, std::size_t bytes_each) {
  const long long n = integer(text("the number of ", what));
  check_count(n, what, bytes_each);
  return static_cast<int>(n);
}

}  // namespace kt
