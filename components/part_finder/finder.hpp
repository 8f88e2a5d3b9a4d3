// The image processing of the component part_finder: finds parts in a grey image of a belt. OpenCV allocates
// memory, so real-time threads must not call these functions.
#pragma once

#include <cmath>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "camera.hpp"

namespace vision {

struct FinderSettings {
  Optics optics{};
  double contrast = 50;  ///< minimum brightness difference between a part and the belt (full scale 255)
};

/// Estimates the brightness of the belt as a plane over the image, because light falls on the belt from one
/// side. The plane fits the pixels of the upper and lower edge, where no parts lie.
inline cv::Mat background(const cv::Mat& image) {
  const int edge = std::max(2, image.rows / 24);
  cv::Matx33d normal = cv::Matx33d::zeros();
  cv::Vec3d right(0, 0, 0);
  for (int v = 0; v < image.rows; ++v) {
    if (v == edge) v = image.rows - edge;
    const auto* row = image.ptr<std::uint8_t>(v);
    for (int u = 0; u < image.cols; ++u) {
      const cv::Vec3d at(1, u, v);
      normal += at * at.t();
      right += at * static_cast<double>(row[u]);
    }
  }
  const cv::Vec3d plane = normal.solve(right, cv::DECOMP_CHOLESKY);
  cv::Mat result(image.size(), CV_32FC1);
  for (int v = 0; v < image.rows; ++v) {
    auto* row = result.ptr<float>(v);
    for (int u = 0; u < image.cols; ++u) row[u] = static_cast<float>(plane[0] + plane[1] * u + plane[2] * v);
  }
  return result;
}

/// Returns a mask: 255 for pixels that are brighter than the belt, 0 for all others, without specks of noise.
inline cv::Mat bright(const cv::Mat& image, double contrast) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {5, 5}, 0);
  cv::Mat above;
  cv::subtract(smooth, background(image), above, cv::noArray(), CV_32FC1);
  cv::Mat mask = above > contrast;
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  return mask;
}

/// Returns the parts that are completely in the image; the part that is farthest along the belt comes first.
/// Ignores shapes that are neither a box nor a bottle, such as a shadow or two parts that touch.
inline std::vector<PlacedPart> find_parts(const cv::Mat& image, const FinderSettings& settings) {
  const Optics& optics = settings.optics;
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(bright(image, settings.contrast), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);

  std::vector<PlacedPart> parts;
  for (const auto& outline : outlines) {
    const cv::Rect around = cv::boundingRect(outline);
    if (around.x <= 1 || around.y <= 1 || around.br().x >= image.cols - 1 || around.br().y >= image.rows - 1)
      continue;  // partly outside the image
    // Use the moments of the pixels. The polygon through the pixel centres is smaller by half a pixel on
    // every side.
    cv::Mat inside = cv::Mat::zeros(around.size(), CV_8UC1);
    cv::drawContours(inside, std::vector<std::vector<cv::Point>>{outline}, 0, cv::Scalar(1), cv::FILLED,
                     cv::LINE_8, cv::noArray(), 0, -around.tl());
    const cv::Moments moments = cv::moments(inside, true);
    const cv::RotatedRect box = cv::minAreaRect(outline);
    const double length = (std::max(box.size.width, box.size.height) + 1) / optics.scale;
    const double width = (std::min(box.size.width, box.size.height) + 1) / optics.scale;
    const double full = moments.m00 / (optics.scale * optics.scale) / (length * width);

    const auto is_about = [](double value, double wanted) { return std::abs(value / wanted - 1) < 0.15; };
    PlacedPart part;
    if (is_about(length, kBoxLength) && is_about(width, kBoxWidth) && full > 0.9)
      part.kind = Kind::box;
    else if (is_about(length, kBodyLength + kNeckLength) && is_about(width, kBodyWidth) && full < 0.9)
      part.kind = Kind::bottle;
    else
      continue;
    part.x = (optics.width / 2.0 - (around.x + moments.m10 / moments.m00 + 0.5)) / optics.scale;
    part.y = ((around.y + moments.m01 / moments.m00 + 0.5) - optics.height / 2.0) / optics.scale;
    part.angle = 0.5 * std::atan2(2 * moments.mu11, moments.mu20 - moments.mu02);
    parts.push_back(part);
  }
  std::sort(parts.begin(), parts.end(), [](const PlacedPart& a, const PlacedPart& b) { return a.x < b.x; });
  return parts;
}

}  // namespace vision
