// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <lcm/lcm-cpp.hpp>

namespace terrace {

/// Has `object->method(buffer, channel)` called inside lcm->handle() for every message on `channel`, which is
/// a regular expression; null when LCM refuses. LCM's own subscribe() keeps the method as a variable, and
/// GCC's undefined-behaviour sanitizer fails on the call through it.
template <auto method, typename Object>
lcm::Subscription* Subscribe(lcm::LCM* lcm, const std::string& channel, Object* object) {
  return lcm->subscribeFunction(
      channel,
      +[](const lcm::ReceiveBuffer* buffer, const std::string& name, Object* receiver) {
        (receiver->*method)(buffer, name);
      },
      object);
}

}  // namespace terrace
