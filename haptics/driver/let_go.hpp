#pragma once
// Every way out of the program lets go of the devices: drivers find no order any more and write zeros.

namespace kt {

/// From any thread, and from a signal's handler.
void let_go_of_devices() noexcept;
bool are_devices_let_go() noexcept;

/// From now on signals that would end the process at once (SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGHUP, SIGQUIT)
/// let go of the devices, wait 60 ms in which drivers write zeros, and end it then. Where one has a handler already, as
/// a sanitizer's, that stays.
void let_go_on_fatal_signals();

/// What is called before the process is ended by hand (_exit): lets go, and waits until zeros are written.
void let_go_and_wait() noexcept;

}  // namespace kt
