// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/lcm_log.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/height_map_v1_t.hpp>
#include <terrace/octree_v1_t.hpp>
#include <terrace/status_v1_t.hpp>
#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/terrain_request_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>

#include "core/file_bytes.h"
#include "datasets/frame_times.h"
#include "datasets/lcm_event_log.h"
#include "datasets/text_table.h"
#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/codec_values.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/sensor_codec.h"

namespace terrace {
namespace {

/// Where a stereo pair lies in the log, and what it says before its pixels are decoded.
struct PairEntry {
  std::int64_t offset = 0;
  Timestamp t;  ///< of the capture
  int width = 0;
  int height = 0;
};

/// Everything in a log but the pixels.
struct LogContents {
  std::vector<PairEntry> pairs;
  std::optional<StereoCalibration> calibration;
  SensorSamples samples;
  std::vector<TimedPose> true_poses;
  std::set<std::string> channels;
  std::vector<std::string> warnings;
};

/// One pass over a log.
class LogScanner {
 public:
  LogScanner(const std::filesystem::path& path, const ChannelConfig& channels)
      : path_(path), channels_(channels) {}

  LogContents Scan() {
    LcmEventReader reader(path_);
    LcmEvent event;
    while (reader.Next(&event)) {
      contents_.channels.insert(event.channel);
      Add(event);
    }
    for (const auto& [channel, count] : num_unreadable_) {
      Warn(std::to_string(count) + " messages on " + channel + " left out: not of the type they should be");
    }
    if (reader.num_skipped_bytes() > 0) {
      Warn(std::to_string(reader.num_skipped_bytes()) + " bytes left out: damaged or cut off");
    }
    if (calibration_changes_) Warn("the calibration changes, the first one is used");
    return std::move(contents_);
  }

 private:
  void Warn(const std::string& what) { contents_.warnings.push_back(path_.string() + ": " + what); }

  template <typename Message, typename Keep>
  void Decode(const LcmEvent& event, Keep keep) {
    const std::optional<Message> message = SafeDecode<Message>(event.data.data(), event.data.size());
    if (!message || !keep(*message)) ++num_unreadable_[event.channel];
  }

  void Add(const LcmEvent& event) {
    const std::string& channel = event.channel;
    if (channel == channels_.images) {
      Decode<images_t>(event, [&](const images_t& message) { return AddPair(event.offset, message); });
    } else if (channel == channels_.calibration) {
      Decode<calibration_v1_t>(event,
                               [&](const calibration_v1_t& message) { return AddCalibration(message); });
    } else if (channel == channels_.imu) {
      Decode<imu_v1_t>(event, [&](const imu_v1_t& message) {
        return KeepIfAny(FromMessage(message), &contents_.samples.imu);
      });
    } else if (channel == channels_.body_prior) {
      Decode<body_prior_v1_t>(event, [&](const body_prior_v1_t& message) {
        return KeepIfAny(FromMessage(message), &contents_.samples.priors);
      });
    } else if (!channels_.body_pose.empty() && channel == channels_.body_pose) {
      Decode<pose_t>(event, [&](const pose_t& message) {
        return KeepIfAny(PriorFromPose(message, channels_.body_pose_prior()), &contents_.samples.priors);
      });
    } else if (channel == channels_.true_pose) {
      Decode<pose_t>(event, [&](const pose_t& message) { return AddTruePose(message); });
    }
  }

  template <typename Sample>
  static bool KeepIfAny(std::optional<Sample> sample, std::vector<Sample>* samples) {
    if (sample) samples->push_back(std::move(*sample));
    return sample.has_value();
  }

  bool AddPair(std::int64_t offset, const images_t& message) {
    const std::optional<Timestamp> t_capture = CaptureTime(message);
    if (!t_capture) return false;
    PairEntry entry{offset, *t_capture};
    if (!message.images.empty()) {
      entry.width = message.images[0].width;
      entry.height = message.images[0].height;
    }
    contents_.pairs.push_back(entry);
    return true;
  }

  bool AddCalibration(const calibration_v1_t& message) {
    if (contents_.calibration) {
      calibration_changes_ = calibration_changes_ || message.content_hash != content_hash_;
      return true;
    }
    contents_.calibration = FromMessage(message);
    if (!contents_.calibration) return false;
    contents_.calibration->name = path_.string() + ": " + channels_.calibration;
    content_hash_ = message.content_hash;
    return true;
  }

  bool AddTruePose(const pose_t& message) {
    const std::optional<Timestamp> t = TimeFromMicroseconds(message.utime);
    const std::optional<Eigen::Isometry3d> pose = FromMessage(message);
    if (t && pose) contents_.true_poses.push_back({*t, *pose});
    return t && pose;
  }

  std::filesystem::path path_;
  ChannelConfig channels_;
  LogContents contents_;
  std::map<std::string, std::int64_t> num_unreadable_;
  std::string content_hash_;
  bool calibration_changes_ = false;
};

/// Sorts by time, messages may have overtaken one another, and leaves out what came twice.
template <typename Sample, typename Same>
void PutInOrder(std::vector<Sample>* samples, Same same) {
  std::stable_sort(samples->begin(), samples->end(),
                   [](const Sample& a, const Sample& b) { return a.t < b.t; });
  samples->erase(std::unique(samples->begin(), samples->end(), same), samples->end());
}

std::string SizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

std::string Listed(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

class LcmLogSequence : public Sequence {
 public:
  LcmLogSequence(const std::filesystem::path& path, const ChannelConfig& channels) : reader_(path) {
    LogContents contents = LogScanner(path, channels).Scan();
    if (contents.pairs.empty()) {
      throw SequenceError(path.string() + ": holds no stereo pairs, which must be images_t on " +
                          channels.images + " (channels.images); its channels: " + Listed(contents.channels));
    }
    if (!contents.calibration) {
      throw SequenceError(path.string() + ": holds no calibration, which must be calibration_v1_t on " +
                          channels.calibration +
                          " (channels.calibration); its channels: " + Listed(contents.channels));
    }
    pairs_ = std::move(contents.pairs);
    samples_ = std::move(contents.samples);
    std::vector<Timestamp> times;
    for (const PairEntry& pair : pairs_) times.push_back(pair.t);
    const std::vector<ClockOffset> clock = OffsetsThatCountOn(times);
    CountOn(clock, &pairs_);
    CountOn(clock, &samples_.imu);
    CountOn(clock, &samples_.priors);
    num_time_jumps_ = KeepRising(&pairs_, [](const PairEntry& pair) { return pair.t; });
    PutInOrder(&samples_.imu, [](const ImuSample& a, const ImuSample& b) { return a.t == b.t; });
    PutInOrder(&samples_.priors,
               [](const BodyPrior& a, const BodyPrior& b) { return a.t == b.t && a.kind == b.kind; });

    info_.kind = SequenceKind::kLcmLog;
    info_.path = path;
    info_.calibration = std::move(*contents.calibration);
    info_.num_frames = static_cast<std::int64_t>(pairs_.size());
    info_.t_first = pairs_.front().t;
    info_.t_last = pairs_.back().t;
    info_.has_imu = !samples_.imu.empty() && info_.calibration.T_body_imu;
    info_.has_attitude = HasPrior(PriorKind::kAttitude);
    info_.has_legs = HasPrior(PriorKind::kLegOdometry);
    info_.has_true_poses = !contents.true_poses.empty();
    info_.warnings = std::move(contents.warnings);
    if (const auto sentence = SentenceAbout(clock))
      info_.warnings.push_back(path.string() + ": " + *sentence);
    if (num_time_jumps_ > 0) {
      info_.warnings.push_back(path.string() + ": " + std::to_string(num_time_jumps_) +
                               " stereo pairs left out: their times must rise");
    }
    times.clear();
    for (const PairEntry& pair : pairs_) times.push_back(pair.t);
    for (const auto& sentence : {StrangeRate(times), OtherClockOfImu(times, samples_.imu)})
      if (sentence) info_.warnings.push_back(path.string() + ": " + *sentence);
    CheckCalibration();
  }

  const SequenceInfo& info() const override { return info_; }
  std::int64_t num_time_jumps() const override { return num_time_jumps_; }

  std::optional<SensorFrame> Next() override {
    if (next_pair_ == pairs_.size()) return std::nullopt;
    const PairEntry& entry = pairs_[next_pair_];
    SensorFrame frame;
    frame.frame_id = static_cast<FrameId>(next_pair_);
    frame.pair = LoadPair(entry);
    frame.samples.imu = TakeUpTo(entry.t, samples_.imu, &next_imu_);
    frame.samples.priors = TakeUpTo(entry.t, samples_.priors, &next_prior_);
    ++next_pair_;
    return frame;
  }

 private:
  bool HasPrior(PriorKind kind) const {
    return std::any_of(samples_.priors.begin(), samples_.priors.end(),
                       [kind](const BodyPrior& prior) { return prior.kind == kind; });
  }

  void CheckCalibration() const {
    const StereoCalibration& calibration = info_.calibration;
    std::vector<std::string> problems = calibration.Problems();
    const auto fits = [&](const PairEntry& pair) {
      return pair.width == calibration.width && pair.height == calibration.height;
    };
    if (problems.empty() && std::none_of(pairs_.begin(), pairs_.end(), fits)) {
      problems.push_back(info_.path.string() + ": images of " + SizeText(pairs_[0].width, pairs_[0].height) +
                         ", must be " + SizeText(calibration.width, calibration.height) + " as " +
                         calibration.name + " says");
    }
    std::string text;
    for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
    if (!text.empty()) throw SequenceError(text);
  }

  StereoPair LoadPair(const PairEntry& entry) {
    StereoPair pair;
    pair.t_capture = entry.t;
    LcmEvent event;
    reader_.Seek(entry.offset);
    const bool read = reader_.Next(&event) && event.offset == entry.offset;
    const auto message = read ? SafeDecode<images_t>(event.data.data(), event.data.size()) : std::nullopt;
    if (!message) {
      pair.problem = info_.path.string() + ": the log changed while it was read";
      return pair;
    }
    pair = FromMessage(*message);
    pair.t_capture = entry.t;  // where a clock was set back, another one than the message's
    const StereoCalibration& calibration = info_.calibration;
    for (const GrayImage* image : {&pair.left, &pair.right}) {
      if (!pair.problem.empty()) break;
      if (image->width == calibration.width && image->height == calibration.height) continue;
      pair.problem = "image of " + SizeText(image->width, image->height) + ", must be " +
                     SizeText(calibration.width, calibration.height) + " as " + calibration.name + " says";
    }
    if (!pair.problem.empty()) pair.left = pair.right = {};
    return pair;
  }

  template <typename Sample>
  static std::vector<Sample> TakeUpTo(Timestamp t, const std::vector<Sample>& samples, std::size_t* next) {
    const std::size_t begin = *next;
    while (*next < samples.size() && samples[*next].t <= t) ++*next;
    return {samples.begin() + static_cast<std::ptrdiff_t>(begin),
            samples.begin() + static_cast<std::ptrdiff_t>(*next)};
  }

  LcmEventReader reader_;
  SequenceInfo info_;
  std::vector<PairEntry> pairs_;
  SensorSamples samples_;
  std::int64_t num_time_jumps_ = 0;
  std::size_t next_pair_ = 0;
  std::size_t next_imu_ = 0;
  std::size_t next_prior_ = 0;
};

template <typename... Messages>
std::map<std::uint64_t, std::string> NamesByFingerprint() {
  return {{static_cast<std::uint64_t>(Messages::getHash()), Messages::getTypeName()}...};
}

std::uint64_t Fingerprint(const std::vector<std::uint8_t>& data) {
  if (data.size() < 8) return 0;
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < 8; ++i) fingerprint = fingerprint << 8 | data[i];
  return fingerprint;
}

void NameType(LcmLogChannel* channel) {
  static const std::map<std::uint64_t, std::string> names =
      NamesByFingerprint<body_prior_v1_t, calibration_v1_t, command_reply_v1_t, command_v1_t, disparity_v1_t,
                         height_map_v1_t, image_t, images_t, imu_v1_t, octree_v1_t, pose_t, pose_v1_t,
                         status_v1_t, terrain_repair_v1_t, terrain_request_v1_t, terrain_v1_t, update_t>();
  const auto name = names.find(channel->fingerprint);
  channel->known = name != names.end();
  if (channel->known) {
    channel->type = name->second;
  } else if (channel->fingerprint == 0) {
    channel->type = "no LCM type";
  } else {
    char text[17];
    std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(channel->fingerprint));
    channel->type = text;
  }
}

}  // namespace

std::unique_ptr<Sequence> OpenLcmLogSequence(const std::filesystem::path& path,
                                             const ChannelConfig& channels) {
  try {
    return std::make_unique<LcmLogSequence>(path, channels);
  } catch (const FileError& error) {
    throw SequenceError(error.what());
  }
}

TrueTrajectory LoadLcmLogTruth(const std::filesystem::path& path, const ChannelConfig& channels) {
  LogContents contents = LogScanner(path, channels).Scan();
  KeepRising(&contents.true_poses, [](const TimedPose& pose) { return pose.t; });
  const bool knows_body = contents.calibration && contents.calibration->T_body_rawleft;
  return {knows_body ? TruthFrame::kBody : TruthFrame::kRawLeft, std::move(contents.true_poses)};
}

std::vector<LcmLogChannel> ListLcmLogChannels(const std::filesystem::path& path) {
  std::map<std::pair<std::string, std::uint64_t>, LcmLogChannel> channels;
  LcmEventReader reader(path);
  LcmEvent event;
  while (reader.Next(&event)) {
    LcmLogChannel& channel = channels[{event.channel, Fingerprint(event.data)}];
    if (channel.num_messages++ == 0) channel.utime_first = event.utime;
    channel.utime_last = event.utime;
    channel.num_bytes += static_cast<std::int64_t>(event.data.size());
  }
  std::vector<LcmLogChannel> list;
  for (auto& [key, channel] : channels) {
    channel.name = key.first;
    channel.fingerprint = key.second;
    NameType(&channel);
    list.push_back(std::move(channel));
  }
  return list;
}

}  // namespace terrace
