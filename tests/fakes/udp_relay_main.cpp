// udp_relay LISTEN_PORT HOST PORT [--delay MS] [--jitter MS] [--loss SHARE] [--duplicate SHARE] [--reorder SHARE]
//           [--rate_mbit R] [--seed N] [--address A]
// A bad network between one client, who calls LISTEN_PORT, and the server at HOST:PORT. Prints its port, and its counts
// when it is ended (Ctrl-C).
#include <csignal>
#include <iostream>
#include <map>

#include "core/base/error.hpp"
#include "network/udp_relay.hpp"

namespace {

double number(const std::string& name, const std::string& value) {
  std::size_t end = 0;
  double x = 0;
  try {
    x = std::stod(value, &end);
  } catch (const std::exception&) {
  }
  if (end == 0 || end != value.size() || !(x >= 0))
    throw kt::InputError(kt::text(name, ": ", value, "; must be a number of at least 0"));
  return x;
}

kt::UdpRelayOptions read(const std::vector<std::string>& args) {
  if (args.size() < 3) throw kt::InputError("udp_relay LISTEN_PORT HOST PORT [--delay MS] [--loss SHARE] ...");
  kt::UdpRelayOptions o;
  o.port = static_cast<int>(number("LISTEN_PORT", args[0]));
  o.host = args[1];
  o.host_port = static_cast<int>(number("PORT", args[2]));
  const std::map<std::string, double*> names{{"--delay", &o.delay_ms},  {"--jitter", &o.jitter_ms},
                                             {"--loss", &o.loss},       {"--duplicate", &o.duplicate},
                                             {"--reorder", &o.reorder}, {"--rate_mbit", &o.rate_mbit}};
  for (std::size_t i = 3; i < args.size(); i += 2) {
    if (i + 1 == args.size()) throw kt::InputError(args[i] + " needs a value");
    if (args[i] == "--seed")
      o.seed = static_cast<std::uint64_t>(number(args[i], args[i + 1]));
    else if (args[i] == "--address")
      o.address = args[i + 1];
    else if (const auto found = names.find(args[i]); found != names.end())
      *found->second = number(args[i], args[i + 1]);
    else
      throw kt::InputError("udp_relay: unknown option " + args[i]);
  }
  return o;
}

void print(const kt::UdpRelayCounts& c) {
  for (std::size_t way : {0, 1})
    std::cout << (way == 0 ? "from the client: " : "from the server: ") << c.received[way] << " received, "
              << c.bytes[way] << " bytes, " << c.lost[way] << " lost, " << c.overflown[way] << " overflown, "
              << c.doubled[way] << " doubled, " << c.reordered[way] << " reordered, " << c.sent[way] << " sent\n";
}

}  // namespace

int main(int argc, char** argv) {
  try {
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGINT);
    sigaddset(&ends, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &ends, nullptr);  // before the relay's thread, which inherits it
    kt::UdpRelay relay(read({argv + 1, argv + argc}));
    std::cout << relay.port() << std::endl;
    int signal = 0;
    sigwait(&ends, &signal);
    print(relay.counts());
    return 0;
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 2;
  }
}
