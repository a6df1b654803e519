#include "network/body_beside.hpp"

#include <atomic>
#include <thread>

#include "core/base/error.hpp"
#include "haptics/setup/built_scene.hpp"
#include "network/body_server.hpp"
#include "network/udp_relay.hpp"

namespace kt {
namespace {

Scene over_network(Scene scene) {
  scene.link.type = "network";
  return scene;
}

BodyServerOptions server_options(const std::string& version, const std::atomic<bool>& stop) {
  BodyServerOptions out;
  out.version = version;
  out.once = true;
  out.stop = &stop;
  return out;
}

}  // namespace

struct BodyBeside::Parts {
  Parts(const Scene& scene, const std::string& version, const std::atomic<bool>* stop_hand, Say say_to)
      : say(std::move(say_to)),
        built(over_network(scene)),
        server(built, "{}", {}, server_options(version, stop), [](const std::string&) {}),
        relay({.host_port = server.port(),
               .delay_ms = scene.link.latency_ms,
               .loss = scene.link.loss,
               .seed = scene.seed}) {
    HandConnectionOptions options;
    options.port = server.port();
    options.data_port = relay.port();
    options.version = version;
    options.stop = stop_hand;
    connection = std::make_shared<HandConnection>(options);
    serving = std::thread([this] {
      try {
        server.run([](const ServedSession&) {});
      } catch (const std::exception& e) {
        say(text("the body's half of the link: ", e.what()));
      }
    });
  }
  ~Parts() {
    stop = true;
    serving.join();
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  Say say;
  std::atomic<bool> stop{false};
  BuiltScene built;
  BodyServer server;
  UdpRelay relay;
  std::shared_ptr<HandConnection> connection;
  std::thread serving;
};

BodyBeside::BodyBeside(const Scene& scene, const std::string& version, const std::atomic<bool>* stop, Say say)
    : parts_(std::make_unique<Parts>(scene, version, stop, std::move(say))) {}

BodyBeside::~BodyBeside() = default;

LinkMaker BodyBeside::link(std::shared_ptr<HandLinkReport> report) {
  const Welcome welcome = parts_->connection->greet(parts_->say);
  return make_hand_link(parts_->connection, welcome, std::move(report), parts_->say);
}

}  // namespace kt
