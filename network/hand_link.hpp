#pragma once
// The link of a touch whose body is on another computer. A thread of its own receives, sends and unpacks; ticks see
// lock-free slots alone, as with a body in a thread.
#include "haptics/touch/body_link.hpp"
#include "network/hand_connection.hpp"

namespace kt {

/// How it went, for the summary.
struct HandLinkReport {
  int models_sent = 0;     ///< by the server, as far as their numbers tell; the first ones too
  int models_arrived = 0;  ///< whole and right
  int models_wrong = 0;    ///< dropped: their numbers do not fit the body
  int models_adopted = 0;
  std::string last_trouble;    ///< of a wrong one
  std::vector<double> age_ms;  ///< of a local model when it was adopted: since its linearization
  /// Of this: at the body, from the motion's coming to the model's going; here, from its coming to its being adopted.
  /// The rest it was on its way, in both directions.
  std::vector<double> body_ms, hand_ms;
  PortCounts port{};                         ///< of all sessions
  std::optional<double> loss_up, loss_down;  ///< of datagrams, measured at the end; none: too few came
  double seconds = 0;                        ///< that the datagrams took
  int reconnections = 0;
  double longest_gap_s = 0;        ///< without a server
  double longest_silence_s = 0;    ///< without a datagram of one that was there
  double longest_own_pause_s = 0;  ///< in which this computer did not run the link: stopped, asleep, too busy
  std::string data_place;          ///< where datagrams went
  std::string without_body;        ///< why the run ended so; empty: it did not
};

/// Makes the link for Touch::start(). The report is filled when the touch stops.
/// @param connection  greeted     @param say  one line: the server is gone, is back
/// @param gave_up     the server has not come back: ticks go on without a force until somebody ends them
LinkMaker make_hand_link(std::shared_ptr<HandConnection> connection, Welcome welcome,
                         std::shared_ptr<HandLinkReport> report, std::function<void(const std::string&)> say,
                         std::function<void()> gave_up = {});

}  // namespace kt
