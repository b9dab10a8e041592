#include "surflux/transfer/incident_light.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"
#include "surflux/transfer/harmonic_lobe.h"

namespace surflux {

namespace {

constexpr std::size_t n = IncidentLight::distant;
constexpr double rim = 1e-3;          // of a lobe's middle: what is darker does not count as below the horizon
constexpr int rings = 4, spokes = 8;  // of what of half a lobe is cut, and of the rest

struct Rule {
    explicit Rule(int count) { gauss_legendre(count, nodes, weights); }
    std::vector<double> nodes, weights;
};

// Light by n harmonics, in a direction, band by band times a factor.
Rgb value(const SphericalHarmonics& basis, const double* bands, const float* light, const Vec3& direction) {
    double at[n];
    basis.evaluate(direction, at);
    Rgb sum;
    std::size_t i = 0;
    for (int l = 0; l < basis.order(); ++l) {
        Rgb of_band;
        for (; i < SphericalHarmonics::count(l + 1); ++i)
            for (int c = 0; c < 3; ++c)
                of_band[c] += at[i] * static_cast<double>(light[3 * i + static_cast<std::size_t>(c)]);
        sum += bands[l] * of_band;
    }
    return sum;
}

// Of a unit lobe around `mirror`, all that is above the horizon: rings by parts of the lobe, for cos^(s + 1) is uniform
// over it, each from the azimuth of the normal to where it goes below. Both rules are Gauss and Legendre's.
Rgb above_horizon(const SphericalHarmonics& basis, double exponent, const float* light, const Vec3& mirror,
                  const Vec3& normal) {
    static const Rule by_ring(rings), by_spoke(spokes);
    static const std::vector<double> even(n, 1.0);
    const double up = dot(mirror, normal), across = std::sqrt(std::max(0.0, 1.0 - up * up));
    const Vec3 u = across > 1e-9 ? (normal - up * mirror) / across : frame_around(mirror).u, v = cross(mirror, u);
    const double whole = std::pow(across, exponent + 1.0);  // from here to 1 rings are
    const auto add_ring = [&](double part, double weight, Rgb& sum) {
        const double cosine = std::pow(part, 1.0 / (exponent + 1.0));
        const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
        const double end = std::acos(std::clamp(-cosine * up / std::max(1e-12, sine * across), -1.0, 1.0));
        for (std::size_t spoke = 0; spoke < spokes; ++spoke) {
            const double phi = end * by_spoke.nodes[spoke];
            const Vec3 towards = cosine * mirror + sine * std::cos(phi) * u, aside = sine * std::sin(phi) * v;
            const double share = weight * by_spoke.weights[spoke] * end / (2.0 * pi);
            sum += share * value(basis, even.data(), light, towards + aside);
            sum += share * value(basis, even.data(), light, towards - aside);
        }
    };
    Rgb sum;
    for (std::size_t ring = 0; ring < rings; ++ring) {
        const double at = by_ring.nodes[ring], weight = by_ring.weights[ring];
        add_ring(whole * (1.0 - at * at), whole * weight * 2.0 * at, sum);  // where rings begin to be cut is a root
        add_ring(whole + (1.0 - whole) * at, (1.0 - whole) * weight, sum);
    }
    return sum;
}

}  // namespace

template <class Visit>
void IncidentLight::for_surfels(const Visit& visit) const {
    transport_->at_surfels.multiply(coefficients_, channels, [&](std::size_t i, const float* sum) {
        float light[channels];
        std::copy_n(sum, channels, light);
        visit(i, light);
    });
}

IncidentLight::Irradiance IncidentLight::irradiance() const {
    const Surfels& s = scene_->scene().surfels;
    const SphericalHarmonics basis(distant_order);
    const std::vector<double> bands = lobe_bands(1.0, distant_order);
    Irradiance out{std::vector<Rgb>(s.size()), std::vector<Rgb>(s.size())};
    for_surfels([&](std::size_t i, float* light) {
        out.distant[i] = value(basis, bands.data(), light, s.normals[i]);
        for (std::size_t k = 0; k < 3 * reflected; ++k) light[k] += light[3 * n + k];
        out.all[i] = value(basis, bands.data(), light, s.normals[i]);
    });
    const std::vector<Rgb>& emitted = emitted_->at_surfels();
    for (std::size_t i = 0; i < emitted.size(); ++i) out.all[i] += emitted[i];
    return out;
}

std::vector<Rgb> IncidentLight::mirrored(const std::vector<Vec3>& directions,
                                         const std::vector<double>& exponents) const {
    const Surfels& s = scene_->scene().surfels;
    const SphericalHarmonics basis(distant_order);
    std::vector<Rgb> out(s.size());
    for_surfels([&](std::size_t i, float* light) {
        const Vec3& normal = s.normals[i];
        const double cosine = dot(normal, directions[i]);
        if (!(cosine > 0.0)) return;
        for (std::size_t k = 0; k < 3 * reflected; ++k) light[k] += light[3 * n + k];
        const Vec3 mirror = 2.0 * cosine * normal - directions[i];
        const double exponent = exponents[i], edge = std::pow(rim, 1.0 / std::max(exponent, 1e-9));
        if (dot(mirror, normal) < std::sqrt(1.0 - edge * edge)) {
            out[i] = above_horizon(basis, exponent, light, mirror, normal);
            return;
        }
        std::vector<double> bands = lobe_bands(exponent, distant_order);
        for (double& band : bands) band *= (exponent + 1.0) / (2.0 * pi);
        out[i] = value(basis, bands.data(), light, mirror);
    });
    for (Rgb& light : out)
        for (int c = 0; c < 3; ++c) light[c] = std::max(0.0, light[c]);
    if (emitted_->any_sampled()) add_emitted(directions, exponents, out);
    return out;
}

void IncidentLight::add_emitted(const std::vector<Vec3>& directions, const std::vector<double>& exponents,
                                std::vector<Rgb>& out) const {
    std::vector<Place> places;
    std::vector<GlossyLobe> lobes;
    for (const Place& place : places_of(scene_->scene().surfels)) {
        const Vec3& towards = directions[place.surfel];
        if (!(dot(place.normal, towards) > 0.0)) continue;
        places.push_back(place);
        lobes.emplace_back(place.normal, towards, Rgb{}, Rgb{1, 1, 1}, exponents[place.surfel]);
    }
    const std::vector<Rgb> found = emitted_->mirrored(places, lobes);
    for (std::size_t k = 0; k < places.size(); ++k) out[places[k].surfel] += found[k];
}

}  // namespace surflux
