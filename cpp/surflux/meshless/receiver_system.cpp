#include "surflux/meshless/receiver_system.h"

#include "surflux/core/parallel.h"
#include "surflux/solution/channels.h"
#include "surflux/solution/gmres.h"

namespace surflux {

namespace {

constexpr int most_applications = 100;

}  // namespace

void ReceiverSystem::add(std::size_t rows, const std::vector<Rgb>& direct) {
    const std::size_t first = rows_.unbounced.size();
    for (std::size_t k = 0; k < rows; ++k) {
        const HemisphereGather::Row& row = gather_[first + k];
        rows_.direct.push_back(direct.empty() ? row.sky : row.sky + direct[k]);
        rows_.unbounced.push_back(rows_.direct.back() + row.emitted);
        rows_.first_bounce.push_back(row.first_bounce);
    }
}

void ReceiverSystem::aim(const std::vector<HemisphereGather::Shot>& rows, const HemisphereGather::Aims& aims,
                         const Progress& progress) {
    const auto add = [&](double sign) {
        for (const HemisphereGather::Shot& of : rows) {
            const HemisphereGather::Row& row = gather_[of.row];
            rows_.direct[of.row] += sign * row.sky;
            rows_.unbounced[of.row] += sign * (row.sky + row.emitted);
            rows_.first_bounce[of.row] = row.first_bounce;
        }
    };
    add(-1.0);
    gather_.aim(rows, aims, progress);
    add(1.0);
}

// T x, and so one bounce of x.
std::vector<Rgb> ReceiverSystem::bounce(const std::vector<Rgb>& x, MeshlessField& field) {
    receivers_.coefficients(x, field.coefficients);
    gather_.sent(field.coefficients, sent_);
    std::vector<Rgb> out(x.size());
    parallel_for(x.size(), 16, [&](std::size_t row) { out[row] = gather_.gather(row, field.coefficients, sent_); });
    return out;
}

LinearReport ReceiverSystem::solve(double tolerance, MeshlessField& field, const Progress& progress) {
    std::vector<Rgb> constant(rows_.unbounced.size());
    for (std::size_t row = 0; row < constant.size(); ++row)
        constant[row] = rows_.unbounced[row] + rows_.first_bounce[row];
    for (std::size_t row = 0; row < correction_.size(); ++row) constant[row] += correction_[row];
    rows_.values.insert(rows_.values.end(), constant.begin() + static_cast<std::ptrdiff_t>(rows_.values.size()),
                        constant.end());
    LinearReport linear;
    if (bounces_ >= 0) {
        rows_.values = before_ = rows_.unbounced;
        for (; linear.applications < bounces_; ++linear.applications) {
            before_ = rows_.values;
            const std::vector<Rgb> arrived = bounce(rows_.values, field);
            for (std::size_t row = 0; row < rows_.values.size(); ++row)
                rows_.values[row] = constant[row] + arrived[row];
        }
    } else {
        const Channels channels(false);
        std::vector<double> x = channels.pack(rows_.values);
        const LinearOperator apply = [&](const std::vector<double>& of, std::vector<double>& to) {
            to = channels.pack(bounce(channels.unpack(of), field));
            for (std::size_t k = 0; k < of.size(); ++k) to[k] = of[k] - to[k];
        };
        linear = gmres(apply, channels.pack(constant), LinearSystems(channels.count, parts_), tolerance,
                       most_applications, x, progress);
        rows_.values = channels.unpack(x);
        before_ = rows_.values;
    }
    receivers_.coefficients(rows_.values, field.coefficients);
    receivers_.coefficients(rows_.direct, field.direct);
    gather_.sent(field.coefficients, sent_);
    return linear;
}

// The constants of rows follow the factors that `set` gives to the gather.
template <class Set>
void ReceiverSystem::set_factors(const Set& set) {
    const auto add = [&](double sign) {
        for (std::size_t row = 0; row < rows_.first_bounce.size(); ++row) {
            const HemisphereGather::Row& of = gather_[row];
            rows_.direct[row] += sign * of.scaled_sky();
            rows_.unbounced[row] += sign * (of.scaled_sky() + of.emitted_scale * of.emitted);
        }
    };
    add(-1.0);
    set();
    add(1.0);
    for (std::size_t row = 0; row < rows_.first_bounce.size(); ++row)
        rows_.first_bounce[row] = gather_[row].first_scale * gather_[row].first_bounce;
}

ReciprocalScaling ReceiverSystem::scale_by_reciprocity(const MeshlessExchange& exchange, const MeshlessField& field,
                                                       const ReciprocityTuning& tuning, const Progress& progress) {
    ReciprocalScaling scaling = exchange.scale_by_reciprocity(field.coefficients, tuning, progress);
    parts_ = exchange.parts();
    set_factors([&] { gather_.set_sender_scale(scaling.senders); });
    return scaling;
}

void ReceiverSystem::keep_power(const MeshlessExchange& exchange, const ReciprocalScaling& scaling,
                                const MeshlessField& field) {
    set_factors([&] { gather_.set_sender_power(exchange.sender_power(scaling, field.coefficients)); });
    gather_.sent(field.coefficients, sent_);
    correction_.resize(rows_.first_bounce.size());
    for (std::size_t row = 0; row < rows_.first_bounce.size(); ++row) {
        const HemisphereGather::Row& of = gather_[row];
        correction_[row] = (of.power_scale - 1.0) * gather_.gather(row, field.coefficients, sent_);
    }
}

}  // namespace surflux
