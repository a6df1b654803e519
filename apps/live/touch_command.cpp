// kilotouch touch HOST:PORT: the hand on this computer, the body on another one.
#include <algorithm>
#include <iostream>

#include "apps/console/commands.hpp"
#include "apps/console/host_and_port.hpp"
#include "apps/console/words.hpp"
#include "apps/live/page_options.hpp"
#include "apps/run/network_run.hpp"
#include "apps/run/run_session.hpp"
#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"

#if KT_WITH_NETWORK
#include "apps/live/live_scene.hpp"
#include "haptics/device/device_backends.hpp"
#include "haptics/device/haptic_device.hpp"
#include "io/files/output_file.hpp"
#include "io/files/shell_words.hpp"
#include "io/scene/named_here.hpp"
#include "network/hand_link.hpp"
#endif
#if KT_WITH_BEAST
#include "apps/live/recordings.hpp"
#endif

namespace kt {
namespace {

struct TouchArguments {
  std::string where, device = "scene", id, keys, server_key, data;
  std::vector<std::string> set;
  double wait = 30;
  RunSettings settings;
  PageArguments page;
  bool no_report = false, shows_page = false;
};

#if KT_WITH_NETWORK

bool is_live_device(const std::string& name) {
  const auto is_it = [&](const BackendInfo& one) { return one.name == name; };
  return std::ranges::any_of(live_device_backends(), is_it);
}

/// What the person at this computer sets: the device first, so that a --set of its address or limits is of this one.
std::vector<std::string> own_settings(const TouchArguments& a) {
  std::vector<std::string> out;
  if (is_live_device(a.device)) out.push_back("tool.path.device.name=" + a.device);
  if (!a.id.empty() && !is_live_device(a.device)) throw InputError("--id: needs --device, the haptic device's name");
  if (!a.id.empty()) out.push_back("tool.path.device.id=" + a.id);
  for (const std::string& one : a.set) {
    if (!one.starts_with("tool.path.") && !one.starts_with("second_tool.path.") && !one.starts_with("duration="))
      throw InputError(text("--set ", one,
                            ": the body's computer has the scene; here only tool.path, second_tool.path and "
                            "duration can be set"));
    out.push_back(one);
  }
  return out;
}

/// A device of the body's scene is not opened here unless somebody here has named one.
void require_own_devices(Scene& scene, const TouchArguments& a, const std::vector<std::string>& set) {
  for (const LiveTool& tool : live_tools(scene)) {
    const std::string path = tool.name + ".path.";
    const bool is_by_pointer = a.device == "pointer" && tool.name == "tool";
    const auto names_another = [&](const std::string& one) {
      return one.starts_with(path) && (!one.starts_with(path + "device.") || one.starts_with(path + "device.name="));
    };
    if (is_by_pointer || std::ranges::any_of(set, names_another)) continue;
    throw InputError(text(path, "device: the body's scene has the device ", tool.device->name,
                          " there; a device of this computer is named here: ",
                          tool.name == "tool" ? "--device NAME, or " : "", "--set ", path, "device.name=NAME"));
  }
}

/// The scene as the other computer has it, with its files in the folder OUT/received: of devices, files and folders of
/// this computer it has no say.
Scene received_scene(const Welcome& welcome, const TouchArguments& a) {
  const std::vector<std::string> set = own_settings(a);
  Scene sent = parse_scene(welcome.scene, {}, "the body's scene");
  static const Scene own = default_scene();  // it names nothing
  require_beside(sent, own, "the body's scene");
  require_own_devices(sent, a, set);
  forget_device_settings(sent);
  sent.title = one_line(sent.title);
  const std::string folder = a.settings.out + "/received";
  make_folder(a.settings.out);
  make_inner_folder(folder);
  for (const Welcome::File& file : welcome.files)
    write_file_whole(folder + "/" + file.name, {reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size()});
  write_file_whole(folder + "/scene.json", to_json(sent));
  Scene scene = load_scene(folder + "/scene.json", set, SceneDoor::others);
  scene.link.type = "network";
  return scene;
}

#if KT_WITH_BEAST

/// The body in a page; each run from rest on is a session of its own with the body's computer.
void show_page(const TouchArguments& a, std::shared_ptr<HandConnection> connection, const Welcome& first,
               const Scene& scene) {
  ViewOptions options = recorded_page(a.page, a.device, a.settings.out, "kilotouch touch");
  const auto next = std::make_shared<std::optional<Welcome>>(first);
  options.link = [connection, next] {
    const auto say = [](const std::string& line) { std::cerr << "kilotouch: " << line << std::endl; };
    if (!*next) {
      connection->ask_again();
      *next = connection->greet(say);
    }
    const LinkMaker out = make_hand_link(connection, **next, std::make_shared<HandLinkReport>(), say);
    next->reset();
    return out;
  };
  view_scene(scene, options);
}

#else

void show_page(const TouchArguments&, std::shared_ptr<HandConnection>, const Welcome&, const Scene&) {
  throw InputError("touch: this program was built without pages; configure with -DKT_WITH_BEAST=ON");
}

#endif

void touch(TouchArguments& a, int& exit_code) {
  const auto [host, port] = host_and_port(a.where, "ADDRESS");
  if (!(a.wait >= 0 && a.wait <= 1e6)) throw InputError(text("--wait is ", a.wait, ", must be 0 .. 1e6 s"));
  const bool by_pointer = a.device == "pointer";
  check_live_device(a.device, {"scene"});
  require_writable_folder(a.settings.out, "--out " + a.settings.out);  // before a server is waited for
  HandConnectionOptions options{.host = host,
                                .port = port,
                                .data_host = {},
                                .own = {},
                                .server_key = {},
                                .version = KT_VERSION,
                                .wait = a.wait,
                                .stop = &stop_requested()};
  if (!a.data.empty()) std::tie(options.data_host, options.data_port) = host_and_port(a.data, "--data");
  if (!a.keys.empty()) options.own = read_key(a.keys);
  if (!a.server_key.empty()) options.server_key = read_public_key(a.server_key, "--server-key");
  if (a.keys.empty() != a.server_key.empty())
    throw InputError("--keys and --server-key go together: this computer's own, and the public one of the server");
  const auto say = [](const std::string& line) { std::cerr << "kilotouch: " << line << std::endl; };
  const auto connection = std::make_shared<HandConnection>(options);
  const Welcome welcome = connection->greet(say);
  const Scene scene = received_scene(welcome, a);
  if (by_pointer || a.shows_page) return show_page(a, connection, welcome, scene);
  const auto report = std::make_shared<HandLinkReport>();
  a.settings.session.link = make_hand_link(connection, welcome, report, say, request_stop);
  tell_of_link(a.settings, report);
  a.settings.input = a.where;
  std::vector<std::string> words{"kilotouch", "touch", a.where, "--device", a.device};
  if (!a.id.empty()) words.insert(words.end(), {"--id", a.id});
  for (const std::string& set : a.set) words.insert(words.end(), {"--set", set});
  a.settings.reproduce = shell_words(words);
  const RunOutcome outcome = run_scene(scene, a.settings);
  print_link(*report);
  exit_code = run_exit_code(outcome);
}

#else

void touch(TouchArguments&, int&) {
  throw InputError("touch: this program was built without it; configure with -DKT_WITH_NETWORK=ON");
}

#endif

}  // namespace

void add_touch_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("touch", "a hand on this computer, the body on another (kilotouch serve)");
  auto a = std::make_shared<TouchArguments>();
  a->settings.out = "out";
  command->add_option("ADDRESS", a->where, "address and port of kilotouch serve")->required();
  command
      ->add_option(
          "--device", a->device,
          "source of the tool's motion, scene (its path), pointer (of the page) or a haptic device (haply ...)")
      ->capture_default_str();
  command->add_option("--id", a->id, "of a haptic device, where there are several (kilotouch device list)");
  command->add_option("--set", a->set, "change tool.path or duration, KEY=VALUE, as often as needed")
      ->allow_extra_args(false);
  command->add_option("--keys", a->keys, "folder of this computer's keys (kilotouch key new)");
  command->add_option("--server-key", a->server_key, "public key of the server, or a file with it");
  command->add_option("--data", a->data, "ADDRESS:PORT of its datagrams, when a relay or a router stands between");
  command->add_option("--wait", a->wait, "for a server that is not there, or is gone, s")->capture_default_str();
  command->add_option("--out", a->settings.out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->settings.json_file, "the summary");
  command->add_flag("--page", a->shows_page, "show the body in a page until Ctrl-C, instead of one run");
  add_page_options(*command, a->page, "page-");
  command->add_flag("--force", a->settings.force, "replace another scene's results in the folder --out");
  command->add_flag("--details", a->settings.details, "print every figure, not the first screen alone");
  command->add_flag("--no-report", a->no_report, "numbers only, without pictures and report.html");
  command->footer(
      "Example:\n  kilotouch touch 192.168.1.20:7700 --device haply --keys keys/hand --server-key body.key");
  command->callback([a, &exit_code] {
    a->settings.report = !a->no_report;
    touch(*a, exit_code);
  });
}

}  // namespace kt
