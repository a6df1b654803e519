#pragma once
// What the two computers say to each other: plain values, and their bytes (FlatBuffers, message/wire.fbs). Bytes that
// come from a network are verified, then every index, count and number of them is checked: what is wrong is no message.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/refresh_record.hpp"
#include "haptics/remote/report_box.hpp"
#include "haptics/remote/sent_model.hpp"
#include "network/channel/sealed.hpp"

namespace kt {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kNetworkProtocol = 2;  ///< both sides must have the same
/// Of the messages' schema: tells versions of the program apart that do not understand each other.
std::uint64_t wire_schema_hash();

/// Kinds of datagram messages. Reports are each given out once, in whatever order they come; of the others the newest.
/// `alive` is empty: the hand asks whether datagrams come through, the body answers with the same.
enum class DatagramKind : std::uint8_t { model = 1, motion = 2, reports = 3 | 0x80, alive = 4 };

/// What an incoming message may name.
struct WireLimits {
  int tools = 1, triangles = 0, nodes = 0, facets_per_triangle = 1;
  double h = 1e-3;  ///< of a tick [s]
};

// ---- Towards the body.

struct ReportMessage {
  ReportBatch batch;
  std::optional<double> loss;  ///< of datagrams from the body, as measured; none: not known yet
  Feedback feedback{};         ///< the same in numbers
};
/// @param tools  that the session has
Bytes encode(const ReportMessage& message, int tools);
std::optional<ReportMessage> decode_reports(std::span<const std::uint8_t> bytes, const WireLimits& limits);

/// Where the local model's nodes are at the start of a tick; the last report is of the tick before it.
struct MotionMessage {
  int frame = -1;                ///< of that model
  LocalMotion motion;            ///< rounded as sent; without `row` and `num_patch`
  int recovered = 0, patch = 0;  ///< nodes in it
  ReportMessage reports;
};
Bytes encode(const MotionMessage& message, int tools);
std::optional<MotionMessage> decode_motion(std::span<const std::uint8_t> bytes, const WireLimits& limits);

// ---- Towards the hand.

struct ModelMessage {
  SentModel model;
  double expected_force_error = 0, force_factor = 0, refresh_ms = 0;  ///< as in TouchStatus
  std::optional<double> loss{};  ///< of datagrams to the body, as measured; none: not known yet
  double body_ms = 0;            ///< since the motion that it is made from came there
};
Bytes encode(const ModelMessage& message);
/// Sizes within the message agree with its bytes; whether it fits the body ModelUnpacker::trouble() tells.
std::optional<ModelMessage> decode_model(std::span<const std::uint8_t> bytes);

// ---- Control.

struct Hello {
  std::uint32_t protocol = kNetworkProtocol;
  std::string version;
  std::uint64_t schema = wire_schema_hash();
  std::uint64_t session = 0;  ///< the hand's own that it has lost; 0: none
};
struct Welcome {
  struct File {
    std::string name;  ///< without folders
    Bytes bytes;
  };
  std::uint64_t session = 0;
  std::array<std::uint8_t, 32> key{};  ///< of datagrams
  int port = 0;                        ///< of datagrams
  std::string scene;                   ///< JSON, with the names of `files`
  std::vector<File> files;
  std::uint64_t body_hash = 0;  ///< of what is built from them, the same on both sides
};
struct Begin {
  std::uint64_t session = 0;
  std::vector<Pose> tools;
  std::vector<double> max_speed;  ///< [m/s]; infinity: not known
  std::optional<BandPowers> motion;
};
struct FirstModel {
  Bytes model;  ///< as by encode(ModelMessage)
};
struct SetRequest {
  std::uint32_t number = 0;
  std::string key;
  double value = 0;
  std::string word;  ///< empty: `value`
};
struct SetReply {
  std::uint32_t number = 0;
  std::string trouble;  ///< empty: done
};
struct RecordMessage {
  RefreshRecord record;  ///< without what self-contact reports
};
struct End {};
// Reasons that may pass.
constexpr const char* kTaken = "somebody else touches the body";
constexpr const char* kOver = "this session is over";
constexpr const char* kEnded = "it ended";  ///< the answer to End
struct Bye {
  std::string reason;
};
struct Ping {};
using ControlMessage =
    std::variant<Hello, Welcome, Begin, FirstModel, SetRequest, SetReply, RecordMessage, End, Bye, Ping>;
Bytes encode(const ControlMessage& message);
std::optional<ControlMessage> decode_control(std::span<const std::uint8_t> bytes);

}  // namespace kt
