// The same messages at the same times over ZeroMQ on TCP, over datagrams with parity and over datagrams alone, through
// one line that delays and loses IP packets: two network namespaces, each with a TUN device, and a thread that carries
// packets from one to the other. Needs root and /dev/net/tun; says so where they are not.
//
//     channel_tcp_table [SECONDS [BYTES]]      of each cell; default 8 s, 74000 bytes, 30 a second
#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <queue>
#include <random>
#include <thread>

#include "network/channel/paced_sender.hpp"
#include "network/channel/sealed.hpp"
#include "network/channel/shards.hpp"
#include "network/channel/udp_socket.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using Bytes = std::vector<std::uint8_t>;
constexpr double kWarm = 1.0;  // [s], not counted
constexpr auto kPeriod = std::chrono::microseconds(33333);
const char* const kSender = "10.77.0.1";
const char* const kReceiver = "10.77.0.2";

[[noreturn]] void stop_with(const char* what) {
  std::perror(what);
  std::exit(2);
}

/// The calling thread, and those that it starts, are in a network of their own from now on.
/// @returns its TUN device: what is written there comes in, what is read there has gone out
int enter_own_network(const std::string& address) {
  if (::unshare(CLONE_NEWNET) != 0) stop_with("a network namespace (root is needed)");
  const int tun = ::open("/dev/net/tun", O_RDWR | O_NONBLOCK);
  if (tun < 0) stop_with("/dev/net/tun");
  ifreq request{};
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  std::strcpy(request.ifr_name, "kt0");
  if (::ioctl(tun, TUNSETIFF, &request) != 0) stop_with("TUNSETIFF");
  const std::string up = "ip address add " + address + "/24 dev kt0 && ip link set kt0 up && ip link set lo up";
  if (std::system(up.c_str()) != 0) stop_with("ip");
  return tun;
}

/// Carries packets between two TUN devices.
class Line {
 public:
  Line(int a, int b, double delay_ms, double loss) : tun_{a, b}, delay_ms_(delay_ms), loss_(loss) {
    Bytes old(2048);  // of the cell before
    for (const int tun : tun_)
      while (::read(tun, old.data(), old.size()) > 0) {
      }
    thread_ = std::thread([this] { run(); });
  }
  ~Line() {
    stop_ = true;
    thread_.join();
  }
  double mbit(double seconds) const { return 8e-6 * static_cast<double>(bytes_) / seconds; }  ///< that was sent

 private:
  struct Packet {
    Clock::time_point due;
    long number = 0;
    int to = 0;
    Bytes bytes;
    bool operator<(const Packet& other) const { return std::pair(due, number) > std::pair(other.due, other.number); }
  };
  void run() {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> draw(0, 1);
    const auto delay =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(delay_ms_));
    std::priority_queue<Packet> queue;
    Bytes packet(2048);
    for (long number = 0; !stop_;) {
      Clock::duration wait = std::chrono::milliseconds(20);
      if (!queue.empty()) wait = std::clamp(queue.top().due - Clock::now(), Clock::duration(0), wait);
      pollfd items[2] = {{tun_[0], POLLIN, 0}, {tun_[1], POLLIN, 0}};
      const timespec time{0, std::chrono::nanoseconds(wait).count()};
      ::ppoll(items, 2, &time, nullptr);
      for (int from = 0; from < 2; ++from)
        for (ssize_t size = 0; (size = ::read(tun_[from], packet.data(), packet.size())) > 0;) {
          if (from == 0) bytes_ += size;
          if (draw(random) < loss_) continue;
          queue.push({Clock::now() + delay, number++, 1 - from, Bytes(packet.begin(), packet.begin() + size)});
        }
      for (; !queue.empty() && queue.top().due <= Clock::now(); queue.pop())
        if (::write(tun_[queue.top().to], queue.top().bytes.data(), queue.top().bytes.size()) < 0) continue;
    }
  }
  int tun_[2];
  double delay_ms_, loss_;
  std::atomic<bool> stop_{false};
  std::atomic<long> bytes_{0};
  std::thread thread_;
};

struct Result {
  long sent = 0;
  std::vector<double> ages;  ///< [ms]
  double mbit = 0;
};

/// What both ways have in common: when a message goes, and the age of one that came, by the time in its first bytes.
class Watch {
 public:
  double now() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void sign(std::uint8_t* message) {
    const double t = now();
    std::memcpy(message, &t, sizeof t);
    out.sent += t > kWarm;
  }
  void came(const void* message) {
    double sent = 0;
    std::memcpy(&sent, message, sizeof sent);
    if (sent > kWarm) out.ages.push_back(1e3 * (now() - sent));
  }
  Clock::time_point start() const { return start_; }
  std::atomic<bool> stop{false};
  Result out;

 private:
  Clock::time_point start_ = Clock::now();
};

/// One message waits at most, a newer one takes its place; the kernel holds no more than two.
void zmq_end(bool sends, Watch& watch, double seconds, std::size_t bytes) {
  void* context = zmq_ctx_new();
  void* socket = zmq_socket(context, sends ? ZMQ_PUSH : ZMQ_PULL);
  const int one = 1, zero = 0, buffer = static_cast<int>(2 * bytes), patience = 20;
  zmq_setsockopt(socket, ZMQ_CONFLATE, &one, sizeof one);
  zmq_setsockopt(socket, ZMQ_LINGER, &zero, sizeof zero);
  zmq_setsockopt(socket, ZMQ_SNDBUF, &buffer, sizeof buffer);
  zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
  const std::string where = std::string("tcp://") + kReceiver + ":7901";
  if ((sends ? zmq_connect(socket, where.c_str()) : zmq_bind(socket, where.c_str())) != 0) stop_with("zmq");
  Bytes message(bytes);
  if (sends) {
    for (auto next = watch.start(); watch.now() < seconds + kWarm; next += kPeriod) {
      std::this_thread::sleep_until(next);
      watch.sign(message.data());
      zmq_send(socket, message.data(), message.size(), ZMQ_DONTWAIT);
    }
  } else {
    while (!watch.stop)
      if (zmq_recv(socket, message.data(), message.size(), 0) == static_cast<int>(bytes)) watch.came(message.data());
  }
  zmq_close(socket);
  zmq_ctx_term(context);
}

struct Shared {
  kt::SealKey key = kt::new_seal_key();
  std::atomic<double> loss{kt::kLossUntilKnown};
};

void take_datagrams(Watch& watch, Shared& shared) {
  kt::UdpSocket socket = kt::UdpSocket::bound(kReceiver, 7902);
  kt::Opener opener(shared.key, 0);
  kt::ShardJoiner joiner;
  Bytes datagram, payload;
  kt::Peer from;
  while (!watch.stop) {
    if (!socket.receive(datagram, from, 20) || !opener.open(datagram, payload)) continue;
    shared.loss = opener.loss().value_or(kt::kLossUntilKnown);
    if (const auto message = joiner.take(payload)) watch.came(message->bytes.data());
  }
}

void send_datagrams(Watch& watch, Shared& shared, bool parity, double seconds, std::size_t bytes) {
  kt::UdpSocket socket = kt::UdpSocket::connected_to(kReceiver, 7902);
  kt::Sealer sealer(shared.key, 0);
  kt::PacedSender sender;
  Bytes datagram;
  kt::Message model;
  model.bytes.resize(bytes);
  for (auto next = watch.start(); watch.now() < seconds + kWarm;) {
    if (Clock::now() >= next) {
      next += kPeriod;
      ++model.number;
      watch.sign(model.bytes.data());
      sender.put(kt::split(model, parity ? shared.loss.load() : -1), false);
    }
    const auto wait = sender.pump(Clock::now(), [&](std::span<const std::uint8_t> payload) {
      sealer.seal(payload, datagram);
      socket.send(datagram);
    });
    std::this_thread::sleep_for(std::min<Clock::duration>(wait ? *wait : kPeriod, next - Clock::now()));
  }
}

/// A thread in each network does what it is given.
class Ends {
 public:
  Ends() : sender_([this] { work(0); }), receiver_([this] { work(1); }) {
    while (ready_ < 2) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ~Ends() {
    over_ = true;
    sender_.join();
    receiver_.join();
  }
  int tun(int end) const { return tun_[end]; }

  Result run(double delay_ms, double loss, double seconds, const std::function<void(Watch&)>& send,
             const std::function<void(Watch&)>& take) {
    Line line(tun_[0], tun_[1], delay_ms, loss);
    Watch watch;
    does_[0] = [&] { send(watch); };
    does_[1] = [&] { take(watch); };
    has_[0] = has_[1] = true;
    const auto wait_for = [&](int end) {
      while (has_[end]) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    };
    wait_for(0);
    std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(delay_ms) + 200));
    watch.stop = true;
    wait_for(1);
    watch.out.mbit = line.mbit(seconds + kWarm);
    std::ranges::sort(watch.out.ages);
    return watch.out;
  }

 private:
  void work(int end) {
    tun_[end] = enter_own_network(end == 0 ? kSender : kReceiver);
    ++ready_;
    for (; !over_; std::this_thread::sleep_for(std::chrono::milliseconds(2)))
      if (has_[end]) {
        does_[end]();
        has_[end] = false;
      }
  }
  std::atomic<int> ready_{0}, tun_[2]{-1, -1};
  std::atomic<bool> over_{false}, has_[2]{false, false};
  std::function<void()> does_[2];
  std::thread sender_, receiver_;
};

std::string told(const Result& r) {
  const auto at = [&](double share) {
    return r.ages.empty() ? 0 : r.ages[static_cast<std::size_t>(share * static_cast<double>(r.ages.size() - 1) + 0.5)];
  };
  char text[96];
  std::snprintf(text, sizeof text, "%zu of %ld, %.0f / %.0f, %.0f", r.ages.size(), r.sent, at(0.5), at(0.99), r.mbit);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (::geteuid() != 0 || ::access("/dev/net/tun", R_OK | W_OK) != 0) {
    std::puts("channel_tcp_table: needs root and /dev/net/tun: nothing measured");
    return 0;
  }
  const double seconds = argc > 1 ? std::atof(argv[1]) : 8;
  const std::size_t bytes = argc > 2 ? static_cast<std::size_t>(std::atol(argv[2])) : 74000;
  std::puts("Each: arrived of sent, age p50 / p99 [ms] of what arrived, Mbit/s.\n");
  std::puts("| each way [ms] | lost | datagrams with parity | datagrams alone | ZeroMQ/TCP, newest only |");
  std::puts("|---|---|---|---|---|");
  Ends ends;
  for (const auto& [delay, loss] : std::initializer_list<std::pair<double, double>>{
           {25, 0}, {25, 0.05}, {25, 0.1}, {25, 0.2}, {25, 0.4}, {100, 0.2}, {200, 0.2}}) {
    std::string cells[3];
    for (int way = 0; way < 3; ++way) {
      Shared shared;
      const auto send = [&](Watch& w) {
        way == 2 ? zmq_end(true, w, seconds, bytes) : send_datagrams(w, shared, way == 0, seconds, bytes);
      };
      const auto take = [&](Watch& w) { way == 2 ? zmq_end(false, w, seconds, bytes) : take_datagrams(w, shared); };
      cells[way] = told(ends.run(delay, loss, seconds, send, take));
    }
    std::printf("| %.0f | %.0f %% | %s | %s | %s |\n", delay, 100 * loss, cells[0].c_str(), cells[1].c_str(),
                cells[2].c_str());
    std::fflush(stdout);
  }
}
