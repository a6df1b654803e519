#pragma once
// Of the process that the engine runs in.

namespace kt {

/// Freed memory is used again: else every refresh fetches its matrices from the system page by page, and gives them
/// back, which takes as long as the reduction itself. For the whole process; Touch does it, once.
void keep_freed_memory() noexcept;

}  // namespace kt
