"""The physical world: pybullet, a Panda, its skills, conditions and disturbances. Nothing else imports pybullet."""
