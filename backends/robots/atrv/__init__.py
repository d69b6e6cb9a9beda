"""The mobile manipulator of Shin et al. (2005): its sides steer it, its arm has five joints."""
