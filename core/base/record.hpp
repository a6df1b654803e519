#pragma once
// Rows of a run that may have no end: in memory at first, then in a file that the system may take out of memory.
#include <algorithm>
#include <cstddef>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

namespace kt {

/// Bytes that only grow. Up to kInMemory they are private memory; beyond, a file without a name in $TMPDIR (/var/tmp
/// without it), mapped and gone with the process. Its space on the disk is taken before it is written to.
class RecordBytes {
 public:
  static constexpr std::size_t kInMemory = std::size_t{16} << 20;  ///< [bytes]

  RecordBytes() = default;
  RecordBytes(RecordBytes&& other) noexcept { *this = std::move(other); }
  RecordBytes& operator=(RecordBytes&& other) noexcept;
  RecordBytes(const RecordBytes&) = delete;
  RecordBytes& operator=(const RecordBytes&) = delete;
  ~RecordBytes();

  /// Room for that many bytes, zeros where nothing was written. The bytes may move; no constructor is called.
  /// @throws RunError when the disk or the memory is full; what was written stays
  void make_room(std::size_t bytes);
  void* data() const { return data_; }
  std::size_t room() const { return room_; }  ///< [bytes]
  bool is_on_disk() const { return file_ >= 0; }
  /// Where such files lie.
  static std::string folder();

 private:
  void* data_ = nullptr;  // mapped
  std::size_t room_ = 0;
  int file_ = -1;
};

/// A list of plain values that only grows, read as a std::span. What it points at moves when it grows.
template <class T>
class Record {
  static_assert(std::is_trivially_destructible_v<T>, "rows are bytes: nothing is called when they move or go");

 public:
  using value_type = T;
  Record() = default;
  Record(Record&& other) noexcept { *this = std::move(other); }
  Record& operator=(Record&& other) noexcept {
    bytes_ = std::move(other.bytes_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  Record(const Record& other) { append(other); }
  Record& operator=(const Record& other) { return *this = Record(other); }
  /// @param row  a copy: it may be one of this list, which moves
  /// @throws RunError as RecordBytes::make_room
  void push_back(T row) { new (place_of_next()) T(row); }
  void append(std::span<const T> rows) {
    for (const T& row : rows) push_back(row);
  }
  /// Longer: with this row. Shorter: the last ones are forgotten.
  void resize(std::size_t size, const T& row) {
    while (size_ < size) push_back(row);
    truncate(size);
  }
  void truncate(std::size_t size) { size_ = std::min(size_, size); }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool is_on_disk() const { return bytes_.is_on_disk(); }
  T* data() { return static_cast<T*>(bytes_.data()); }
  const T* data() const { return static_cast<const T*>(bytes_.data()); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  T& back() { return data()[size_ - 1]; }
  const T& back() const { return data()[size_ - 1]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }

 private:
  void* place_of_next() {
    const std::size_t needed = (size_ + 1) * sizeof(T);
    if (needed > bytes_.room()) bytes_.make_room(needed);
    return data() + size_++;
  }

  RecordBytes bytes_;
  std::size_t size_ = 0;
};

}  // namespace kt
