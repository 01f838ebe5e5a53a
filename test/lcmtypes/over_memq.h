// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>

#include "lcmtypes/safe_decode.h"

namespace terrace {

/// The message after a trip through an LCM of this process.
template <typename Message>
std::optional<Message> OverMemq(const Message& message) {
  lcm::LCM lcm("memq://");
  std::optional<Message> received;
  lcm.subscribeFunction(
      "TRIP",
      +[](const lcm::ReceiveBuffer* buffer, const std::string&, std::optional<Message>* out) {
        *out = SafeDecode<Message>(buffer->data, buffer->data_size);
      },
      &received);
  lcm.publish("TRIP", &message);
  lcm.handleTimeout(1000);
  return received;
}

}  // namespace terrace
