// kilotouch serve SCENE: the body on this computer, for a hand on another one.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <thread>

#include "apps/console/commands.hpp"
#include "apps/console/host_and_port.hpp"
#include "apps/live/page_options.hpp"
#include "apps/run/network_run.hpp"
#include "core/base/error.hpp"

#if KT_WITH_NETWORK
#include "apps/live/live_scene.hpp"
#include "apps/run/given_file.hpp"
#include "haptics/session/session.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/mesh/mesh_pair.hpp"
#include "io/scene/named_here.hpp"
#include "network/body_server.hpp"
#endif
#if KT_WITH_BEAST
#include "view/view.hpp"
#endif

namespace kt {
namespace {

struct ServeArguments {
  std::string scene, listen = text("127.0.0.1:", kUsualPort), keys, authorized;
  std::vector<std::string> set;
  PageArguments page;
  bool once = false, shows_page = false;
};

#if KT_WITH_NETWORK

namespace fs = std::filesystem;

Welcome::File whole_file(const std::string& path, const std::string& name) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(text(path, ": cannot be read"));
  return {name, {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()}};
}

/// What the scene names, under names of their own: the scene's text is changed to them. Of a device the hand's computer
/// learns that there is one.
std::vector<Welcome::File> take_files(Scene& scene) {
  std::vector<Welcome::File> out;
  for (const NamedPlace& named : scene_files(scene)) {
    std::string& path = *named.place;
    const std::string other = other_of_pair(path);  // read by its reader, under the same name
    std::string name = named.key;                   // "tool_path_recording"
    std::ranges::replace(name, '.', '_');
    if (!other.empty()) out.push_back(whole_file(other, name + mesh_extension(other)));
    out.push_back(whole_file(path, name + fs::path(path).extension().string()));
    path = out.back().name;
  }
  forget_device_settings(scene);
  return out;
}

void tell(const ServedSession& s, int port) {
  if (!s.begun) {
    std::cout << "  session       did not begin" << std::endl;
    return;
  }
  if (s.port.opened.opened == 0) {
    std::cout << "  session       felt nothing: no datagram of the hand came over UDP port " << port
              << "; let it through (firewall, router), as TCP" << std::endl;
    return;
  }
  const auto mbit = [&](long long bytes) { return s.ticks > 0 ? 8e-6 * static_cast<double>(bytes) : 0; };
  std::cout << "  session       " << s.ticks << " ticks; " << s.body.models << " local models, "
            << mbit(s.port.bytes_sent) << " Mbit sent, " << mbit(s.port.bytes_received) << " received\n"
            << "  datagrams     lost " << loss_text(s.loss_down) << " to the hand, " << loss_text(s.loss_up)
            << " from it; " << s.port.opened.refused() << " refused, " << s.wrong_messages << " messages wrong\n"
            << "  reports       " << s.body.inbox.received << " ticks, " << s.body.inbox.lost
            << " never came: their impulses were given to the body with the next ones (" << s.body.inbox.booked_size
            << " N.s)" << std::endl;
}

struct JoinAtEnd {
  std::thread& thread;
  ~JoinAtEnd() {
    request_stop();
    if (thread.joinable()) thread.join();
  }
};

#if KT_WITH_BEAST

/// A frame for a picture: what the last report of the hand tells.
std::vector<LocalFrame> frames_of(const LocalReport& report, std::size_t tools, double h) {
  std::vector<LocalFrame> out(tools);
  for (std::size_t k = 0; k < tools; ++k) {
    LocalFrame& f = out[k];
    f.t = (report.tick + 1) * h;
    f.pose = report.tools[k].pose;
    f.triangle = report.tools[k].triangle;
    double most = 0;
    for (const TickContact& c : report.contacts()) {
      if (c.tool != static_cast<int>(k)) continue;
      const Vec3 force = -1 / h * c.impulse;  // on the tool
      f.force += force;
      f.f_n += force.dot(c.normal);
      ++f.contacts;
      if (force.norm() <= most) continue;
      most = force.norm();
      f.normal = c.normal;
      f.point = c.point;
      f.mode = c.sticks ? ContactMode::stick : ContactMode::frictional_slide;
    }
    f.f_t = std::sqrt(std::max(0.0, f.force.squaredNorm() - f.f_n * f.f_n));
    f.model_frame = report.model_frame;
    if (report.left_patch) f.flags |= kLeftPatch;
  }
  return out;
}

void show_page(const PageArguments& page, const Session& session, const BodyServer& server,
               const std::atomic<bool>& is_over) {
  check_page(page);
  ViewOptions options;
  options.server = {page.listen, static_cast<unsigned short>(page.port), page.token};
  options.by_pointer = false;
  options.stop = &is_over;
  options.ready = [page](const std::string& url) { tell_of_page(page, url); };
  view_watched(
      session,
      [&](WatchedBody& out) {
        LocalReport report;
        if (!server.look(out.x, report, out.status)) return false;
        out.tools = frames_of(report, session.tools().size(), 1 / session.scene().local.rate_hz);
        return true;
      },
      options);
}

#else

void show_page(const PageArguments&, const Session&, const BodyServer&, const std::atomic<bool>&) {
  throw InputError("serve: this program was built without pages; configure with -DKT_WITH_BEAST=ON");
}

#endif

void serve(const ServeArguments& a) {
  const auto [address, port] = host_and_port(a.listen, "--listen");
  BodyServerOptions options{.address = address,
                            .port = port,
                            .own = {},
                            .authorized = {},
                            .version = KT_VERSION,
                            .once = a.once,
                            .stop = &stop_requested()};
  if (!a.keys.empty()) options.own = read_key(a.keys);
  if (!a.authorized.empty()) {
    if (a.keys.empty()) throw InputError("--authorized: needs --keys, this computer's own");
    options.authorized = read_authorized(a.authorized);
  }
  Scene scene = scene_of_file(a.scene, a.set);
  scene.link.type = "network";
  const Session built(scene);
  for (const std::string& line : lines(built.findings())) std::cerr << "kilotouch: warning: " << line << '\n';
  Scene sent = scene;
  std::vector<Welcome::File> files = take_files(sent);
  BodyServer server(built, to_json(sent), std::move(files), options,
                    [](const std::string& line) { std::cout << line << std::endl; });
  const auto tell_of = [&](const ServedSession& s) { tell(s, server.port()); };
  std::cout << "serving " << a.scene << " on " << address << ":" << server.port()
            << (options.own ? ", public key " + options.own->public_key : "") << "; Ctrl-C ends it" << std::endl;
  if (options.own && !options.authorized)
    std::cerr << "kilotouch: warning: --keys without --authorized: every key is let in; who has this computer's public "
                 "key may touch the body. --authorized FILE names those who may"
              << std::endl;
  if (!a.shows_page) return server.run(tell_of);
  std::exception_ptr error;
  std::atomic<bool> is_over{false};
  std::thread serving([&] {
    try {
      server.run(tell_of);
    } catch (...) {
      error = std::current_exception();
    }
    is_over = true;
  });
  const JoinAtEnd joins{serving};
  show_page(a.page, built, server, is_over);
  request_stop();
  serving.join();
  if (error) std::rethrow_exception(error);
}

#else

void serve(const ServeArguments&) {
  throw InputError("serve: this program was built without it; configure with -DKT_WITH_NETWORK=ON");
}

#endif

}  // namespace

void add_serve_command(CLI::App& app, int&) {
  auto* command = app.add_subcommand("serve", "the body of a scene, for a hand on another computer (kilotouch touch)");
  auto a = std::make_shared<ServeArguments>();
  command->add_option("SCENE", a->scene, "scene file (docs/scene.md)")->required();
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE, as often as needed")
      ->allow_extra_args(false);
  command->add_option("--listen", a->listen, "address and port, beyond this computer with --keys")
      ->capture_default_str();
  command->add_option("--keys", a->keys, "folder of this computer's keys (kilotouch key new)");
  command->add_option("--authorized", a->authorized, "file of public keys that may connect, one a line");
  command->add_flag("--page", a->shows_page, "show the body in a page");
  add_page_options(*command, a->page, "page-");
  command->add_flag("--once", a->once, "end with the first hand's session");
  command->footer(
      "Example:\n  kilotouch serve scenes/organ_drag.json --listen 0.0.0.0:7700 --keys keys/body "
      "--authorized hands.txt");
  command->callback([a] { serve(*a); });
}

}  // namespace kt
