// SPDX-License-Identifier: BSD-3-Clause
#include "tools/v4l2_camera.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

namespace terrace {
namespace {

// The newest two wait while we work on one and the device fills one.
constexpr unsigned kNumBuffers = 4;

/// Again when a signal interrupts it.
int Control(int fd, unsigned long request, void* argument) {
  int result;
  do {
    result = ioctl(fd, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

// librealsense's name for two infrared images byte by byte; the kernel has it since 4.
constexpr std::uint32_t kY8i = v4l2_fourcc('Y', '8', 'I', ' ');

std::uint32_t FourCharacters(PixelFormat format) {
  switch (format) {
    case PixelFormat::kGrey:
      return V4L2_PIX_FMT_GREY;
    case PixelFormat::kYuyv:
      return V4L2_PIX_FMT_YUYV;
    case PixelFormat::kMjpeg:
      return V4L2_PIX_FMT_MJPEG;
    case PixelFormat::kY8i:
      return kY8i;
  }
  return 0;
}

std::string InLetters(std::uint32_t fourcc) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) text.push_back(static_cast<char>(fourcc >> shift & 0x7f));
  return text;
}

/// "YUYV 1280x480, YUYV 2560x960, MJPG 2560x960": what may be asked for.
std::string Offers(int fd) {
  std::string text;
  v4l2_fmtdesc format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; Control(fd, VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    v4l2_frmsizeenum size{};
    size.pixel_format = format.pixelformat;
    for (; Control(fd, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) break;
      text += (text.empty() ? "" : ", ") + InLetters(format.pixelformat) + " " +
              std::to_string(size.discrete.width) + "x" + std::to_string(size.discrete.height);
    }
  }
  return text.empty() ? "nothing that it tells" : text;
}

Timestamp Read(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return {static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec};
}

Timestamp StampOf(const v4l2_buffer& buffer) {
  const Timestamp system_now = Read(CLOCK_REALTIME);
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return system_now;
  const Timestamp stamp{static_cast<std::int64_t>(buffer.timestamp.tv_sec) * 1'000'000'000 +
                        static_cast<std::int64_t>(buffer.timestamp.tv_usec) * 1000};
  return OnSystemClock(stamp, Read(CLOCK_MONOTONIC), system_now);
}

}  // namespace

V4l2Camera::V4l2Camera(const std::string& device, const CameraConfig& config) : device_(device) {
  fd_ = open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) Gone(std::strerror(errno));
  try {
    RequireCapture();
    SetFormat(config);
    SetControls(config);
    Start();
  } catch (...) {
    Stop();
    throw;
  }
}

V4l2Camera::~V4l2Camera() { Stop(); }

void V4l2Camera::Gone(const std::string& what) const { throw CameraGone(device_ + ": " + what); }

void V4l2Camera::RequireCapture() {
  v4l2_capability capability{};
  if (Control(fd_, VIDIOC_QUERYCAP, &capability) < 0) throw std::runtime_error(device_ + ": no video device");
  const std::uint32_t caps =
      capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  if ((caps & V4L2_CAP_VIDEO_CAPTURE) == 0 || (caps & V4L2_CAP_STREAMING) == 0) {
    throw std::runtime_error(device_ +
                             ": a video device that sends no images (a camera often has several; v4l2-ctl "
                             "--list-devices names them)");
  }
}

void V4l2Camera::SetFormat(const CameraConfig& config) {
  format_ = *PixelFormatFromName(config.format);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<std::uint32_t>(config.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(config.height);
  format.fmt.pix.pixelformat = FourCharacters(format_);
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (Control(fd_, VIDIOC_S_FMT, &format) < 0) {
    if (errno == EBUSY) Gone("another program uses it");
    throw std::runtime_error(device_ + ": " + std::strerror(errno) + "; it offers " + Offers(fd_));
  }
  width_ = static_cast<int>(format.fmt.pix.width);
  height_ = static_cast<int>(format.fmt.pix.height);
  // Drivers answer with what they would rather send.
  if (width_ != config.width || height_ != config.height ||
      format.fmt.pix.pixelformat != FourCharacters(format_)) {
    throw std::runtime_error(device_ + ": sends " + InLetters(format.fmt.pix.pixelformat) + " " +
                             std::to_string(width_) + "x" + std::to_string(height_) + " instead of " +
                             config.format + " " + std::to_string(config.width) + "x" +
                             std::to_string(config.height) + "; it offers " + Offers(fd_));
  }
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe.numerator = 1000;
  parameters.parm.capture.timeperframe.denominator =
      static_cast<std::uint32_t>(std::lround(1000.0 * config.rate_hz));
  if (Control(fd_, VIDIOC_S_PARM, &parameters) < 0) notes_.push_back(device_ + ": its rate cannot be set");
}

void V4l2Camera::SetControl(std::uint32_t id, std::int64_t value, const char* name) {
  v4l2_control control{};
  control.id = id;
  control.value = static_cast<std::int32_t>(value);
  if (Control(fd_, VIDIOC_S_CTRL, &control) < 0)
    notes_.push_back(device_ + ": " + name + " cannot be set to " + std::to_string(value) + ": " +
                     std::strerror(errno));
}

void V4l2Camera::SetControls(const CameraConfig& config) {
  if (config.exposure_us > 0.0) {
    constexpr double kUnitUs = 100.0;  // of V4L2_CID_EXPOSURE_ABSOLUTE
    SetControl(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "manual exposure");
    SetControl(V4L2_CID_EXPOSURE_ABSOLUTE, std::lround(config.exposure_us / kUnitUs), "exposure");
  }
  if (config.gain >= 0) SetControl(V4L2_CID_GAIN, config.gain, "gain");
}

void V4l2Camera::Start() {
  v4l2_requestbuffers request{};
  request.count = kNumBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (Control(fd_, VIDIOC_REQBUFS, &request) < 0)
    Gone(errno == EBUSY ? "another program uses it" : std::strerror(errno));
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = i;
    if (Control(fd_, VIDIOC_QUERYBUF, &buffer) < 0) Gone(std::strerror(errno));
    void* start = mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, buffer.m.offset);
    if (start == MAP_FAILED) Gone(std::strerror(errno));
    buffers_.push_back({start, buffer.length});
    if (Control(fd_, VIDIOC_QBUF, &buffer) < 0) Gone(std::strerror(errno));
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (Control(fd_, VIDIOC_STREAMON, &type) < 0) Gone(std::strerror(errno));
}

void V4l2Camera::Stop() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  Control(fd_, VIDIOC_STREAMOFF, &type);  // fails where it never began, which is as well
  for (const Buffer& buffer : buffers_) munmap(buffer.start, buffer.size);
  buffers_.clear();
  close(fd_);
}

std::optional<RawFrame> V4l2Camera::Next(int patience_ms) {
  pollfd waiting{fd_, POLLIN, 0};
  const int ready = poll(&waiting, 1, patience_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return std::nullopt;
  if (ready < 0 || (waiting.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) Gone("unplugged");
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  if (Control(fd_, VIDIOC_DQBUF, &buffer) < 0) {
    if (errno == EAGAIN) return std::nullopt;
    Gone(errno == ENODEV ? "unplugged" : std::strerror(errno));
  }
  RawFrame frame;
  frame.t = StampOf(buffer);
  frame.t_is_begin = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  frame.format = format_;
  frame.width = width_;
  frame.height = height_;
  frame.sequence = buffer.sequence;
  // A frame that the driver calls damaged keeps no bytes, and becomes a pair with a problem.
  const bool damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || buffer.index >= buffers_.size();
  if (!damaged) {
    const auto* bytes = static_cast<const std::uint8_t*>(buffers_[buffer.index].start);
    const std::size_t size = std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].size);
    frame.data.assign(bytes, bytes + size);
  }
  if (Control(fd_, VIDIOC_QBUF, &buffer) < 0) Gone(std::strerror(errno));
  return frame;
}

}  // namespace terrace
