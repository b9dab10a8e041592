#pragma once

namespace surflux {

// A gradient in the plane, fitted by weighted least squares to differences at offsets (x, y), with ridge
// regularization.
template <class Value>
class SlopeFit {
public:
    // `stiffness` is against slopes that neighbours on one line do not give; all slopes are too small by as much.
    explicit SlopeFit(double stiffness = 0.1) : stiffness_(stiffness) {}

    void add(double x, double y, double weight, const Value& rise) {
        uu_ += weight * x * x;
        uv_ += weight * x * y;
        vv_ += weight * y * y;
        u_ += (weight * x) * rise;
        v_ += (weight * y) * rise;
    }
    // False where nothing was added from which it follows.
    bool solve(Value& along_x, Value& along_y) const {
        const double ridge = 0.5 * stiffness_ * (uu_ + vv_);
        const double uu = uu_ + ridge, vv = vv_ + ridge;
        const double determinant = uu * vv - uv_ * uv_;
        if (!(determinant > 0.0)) return false;
        along_x = (vv * u_ - uv_ * v_) / determinant;
        along_y = (uu * v_ - uv_ * u_) / determinant;
        return true;
    }

private:
    double stiffness_;
    double uu_ = 0.0, uv_ = 0.0, vv_ = 0.0;
    Value u_{}, v_{};
};

}  // namespace surflux
