#pragma once
// Stands for the daemon of 6-axis mice: a UNIX socket that sends protocol 0's events, eight 32-bit integers each.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <string>

namespace kt::fake {

class Spacenavd {
 public:
  explicit Spacenavd(std::string path) : path_(std::move(path)) { start(); }
  ~Spacenavd() { stop(); }

  void start() {
    unlink(path_.c_str());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    listen(listener_, 4);
  }
  void accept() { client_ = ::accept(listener_, nullptr, nullptr); }  ///< waits for somebody
  void stop() {
    hang_up();
    if (listener_ >= 0) close(listener_);
    listener_ = -1;
    unlink(path_.c_str());
  }
  void hang_up() {
    if (client_ >= 0) close(client_);
    client_ = -1;
  }
  void send(const std::int32_t (&event)[8]) { send_bytes(event, sizeof event); }
  void send_bytes(const void* bytes, std::size_t count) { ::send(client_, bytes, count, MSG_NOSIGNAL); }
  void motion(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t rx = 0, std::int32_t ry = 0,
              std::int32_t rz = 0) {
    send({0, x, y, z, rx, ry, rz, 8});
  }
  void button(int number, bool is_pressed) { send({is_pressed ? 1 : 2, number, 0, 0, 0, 0, 0, 0}); }

 private:
  std::string path_;
  int listener_ = -1, client_ = -1;
};

}  // namespace kt::fake
